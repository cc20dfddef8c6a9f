// What is searched and compared: of each kept animation the path of every body's centre, whom it
// met and when, and its numbers.
//
// An index is of one run (browse/reading.h fills it out of an archive). Its entries are in the
// archive's order. Turns of bodies are left out: no query and no resemblance asks for them.
//
// Units are SI, times count from the animation's beginning. Thread safety: values.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/math/vector.h"
#include "common/scene/scene.h"

namespace sleight::browse {

/// What an animation is called, whatever archive of its run it is in: run, chain and draw; of a
/// search's finds, which belong to no chain, run and number.
struct AnimationName {
  std::string run{};     ///< run_id of the archive
  bool is_find = false;  ///< then chain is 0
  std::uint64_t chain = 0;
  std::uint64_t draw = 0;  ///< of a find: its row in /finds
  friend auto operator<=>(const AnimationName&, const AnimationName&) = default;
};

/// A run's name among others, where people read it.
inline constexpr std::size_t k_run_letters = 8;
/// Within an archive: "c0.250" (chain 0, draw 250) or "find.3", which no table takes for a number.
std::string short_text(const AnimationName& name);
/// Among several runs: the first eight characters of the run, and that: "3f2a9c01:c0.250".
std::string long_text(const AnimationName& name);

/// A name as a person writes it, short or long.
struct AskedName {
  std::string run{};  ///< the first characters of its run; empty: of any
  bool is_find = false;
  std::uint64_t chain = 0;
  std::uint64_t draw = 0;
  bool is_bare = false;  ///< "0.250", as ids once were: 0.25 to a table
};
/// None of a text that is no name.
std::optional<AskedName> parse_name(std::string_view text);

/// A piece of the path of a body's centre: position + velocity s + acceleration s^2 / 2 with s from
/// start_s on, until the body's next piece; the last one has no end. A whole motion::Segment is
/// twice as large: with that, an index takes twice the memory and searches are a quarter slower.
struct Piece {
  double start_s = 0;
  math::Vec3 position_m{0, 0, 0};
  math::Vec3 velocity_mps{0, 0, 0};
  math::Vec3 acceleration_mps2{0, 0, 0};
  friend bool operator==(const Piece&, const Piece&) = default;
};

/// A box of places; the default is all of space. Its faces belong to it.
struct Box {
  math::Vec3 low_m = math::Vec3::Constant(-std::numeric_limits<double>::infinity());
  math::Vec3 high_m = math::Vec3::Constant(std::numeric_limits<double>::infinity());
  friend bool operator==(const Box&, const Box&) = default;
};

/// The pieces of one body, and a box that its centre never leaves.
struct Track {
  std::uint32_t first = 0;  ///< its first piece in Entry::pieces
  std::uint32_t count = 0;  ///< 0: it never enters
  Box reach{};
  friend bool operator==(const Track&, const Track&) = default;
};

/// A recorded hit.
struct Contact {
  double time_s = 0;
  std::uint32_t body = 0;
  std::uint32_t partner = 0;  ///< a feature of the scene
  friend bool operator==(const Contact&, const Contact&) = default;
};

struct Entry {
  AnimationName name{};
  std::uint64_t row = 0;     ///< in /animations or /finds
  std::int64_t lineage = 0;  ///< 0 of finds
  bool in_proportion = false;
  double end_s = 0;                 ///< when the last body came to rest
  std::uint32_t events = 0;         ///< what began a segment, but for bodies that enter
  std::vector<double> numbers{};    ///< along Index::numbers
  std::vector<Track> tracks{};      ///< by body
  std::vector<Piece> pieces{};      ///< body by body, each in the order of time
  std::vector<Contact> contacts{};  ///< in the order of (time, body, partner)

  std::span<const Piece> pieces_of(std::uint32_t body) const {
    return std::span(pieces).subspan(tracks[body].first, tracks[body].count);
  }
};
bool operator==(const Entry& a, const Entry& b);

/// A number that every animation has: "log_prior", "landing_m", "upper_face[2]".
struct NumberName {
  std::string name{};
  std::string unit{};  ///< "m"; "1": a pure number
  friend bool operator==(const NumberName&, const NumberName&) = default;
};

/// The numbers that each index has, before those of its world.
inline constexpr std::size_t k_log_prior = 0;
inline constexpr std::size_t k_log_constraint = 1;
inline constexpr std::size_t k_chain = 2;
inline constexpr std::size_t k_draw = 3;
inline constexpr std::size_t k_lineage = 4;
inline constexpr std::size_t k_rest_s = 5;
inline constexpr std::size_t k_events = 6;
inline constexpr std::size_t k_in_proportion = 7;
inline constexpr std::size_t k_own_numbers = 8;

/// Their names: log_prior, log_constraint, chain, draw, lineage, rest_s (when the last body came to
/// rest), events, in_proportion (0 or 1).
const std::vector<NumberName>& own_numbers();

struct Index {
  std::string run_id{};
  std::string digest{};  ///< of the archive it was read from, as stored there
  std::string world{};
  scene::Scene scene{};
  std::vector<NumberName> numbers{};
  std::vector<Entry> entries{};
};

/// The piece in force, the last if several begin then; null before the first.
const Piece* piece_at(std::span<const Piece> pieces, double t_s);
/// Where the centre is; nothing before the body enters. After the last piece began, what that says.
std::optional<math::Vec3> centre_at(std::span<const Piece> pieces, double t_s);

/// Sets `reach` of every track. REQUIRES: tracks and pieces that fit.
void measure_reach(Entry& entry);

}  // namespace sleight::browse
