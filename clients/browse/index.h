// The animation index, which queries and comparisons read: the path of every body's centre, its
// hits and the animation's numbers, for each kept animation.
//
// An index belongs to one run (browse/reading.h reads it from an archive). Entries are in the
// archive's order. Orientations are omitted, because neither queries nor comparisons use them.
//
// Units are SI. Times count from the animation's beginning. Thread safety: values.
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

/// The name of an animation, which is the same in all archives of its run. A name consists of the
/// run, the chain and the draw. The name of a find consists of the run and the find's number.
struct AnimationName {
  std::string run{};     ///< run_id of the archive
  bool is_find = false;  ///< finds: chain is 0
  std::uint64_t chain = 0;
  std::uint64_t draw = 0;  ///< finds: row in /finds
  friend auto operator<=>(const AnimationName&, const AnimationName&) = default;
};

/// Length of a run's short name for people.
inline constexpr std::size_t k_run_letters = 8;
/// Returns the name within an archive: "c0.250" (chain 0, draw 250) or "find.3". Spreadsheets don't
/// mistake such names for numbers.
std::string short_text(const AnimationName& name);
/// Returns the name among several runs: the first eight characters of the run id and short_text(),
/// such as "3f2a9c01:c0.250".
std::string long_text(const AnimationName& name);

struct AskedName {
  std::string run{};  ///< first characters of the run id; empty: any run
  bool is_find = false;
  std::uint64_t chain = 0;
  std::uint64_t draw = 0;
  bool is_bare = false;  ///< old form such as "0.250", which a spreadsheet may turn into 0.25
};
/// Returns nothing if the text isn't a name.
std::optional<AskedName> parse_name(std::string_view text);

/// A piece of the path of a body's centre: position + velocity s + acceleration s^2 / 2, with s
/// counted from start_s. A piece lasts until the body's next piece; the last piece has no end. An
/// index of motion::Segments, which are twice as large, would take twice the memory and slow
/// searches by a quarter.
struct Piece {
  double start_s = 0;
  math::Vec3 position_m{0, 0, 0};
  math::Vec3 velocity_mps{0, 0, 0};
  math::Vec3 acceleration_mps2{0, 0, 0};
  friend bool operator==(const Piece&, const Piece&) = default;
};

/// A closed box in space. Default: all of space.
struct Box {
  math::Vec3 low_m = math::Vec3::Constant(-std::numeric_limits<double>::infinity());
  math::Vec3 high_m = math::Vec3::Constant(std::numeric_limits<double>::infinity());
  friend bool operator==(const Box&, const Box&) = default;
};

/// A body's pieces, and a box that its centre never leaves.
struct Track {
  std::uint32_t first = 0;  ///< index into Entry::pieces
  std::uint32_t count = 0;  ///< 0: the body never enters
  Box reach{};
  friend bool operator==(const Track&, const Track&) = default;
};

struct Contact {
  double time_s = 0;
  std::uint32_t body = 0;
  std::uint32_t partner = 0;  ///< scene feature
  friend bool operator==(const Contact&, const Contact&) = default;
};

struct Entry {
  AnimationName name{};
  std::uint64_t row = 0;     ///< row in /animations or /finds
  std::int64_t lineage = 0;  ///< 0 for finds
  bool in_proportion = false;
  double end_s = 0;                 ///< time when the last body came to rest
  std::uint32_t events = 0;         ///< events that began a segment, except entering bodies
  std::vector<double> numbers{};    ///< parallel to Index::numbers
  std::vector<Track> tracks{};      ///< by body
  std::vector<Piece> pieces{};      ///< body by body, each in the order of time
  std::vector<Contact> contacts{};  ///< in the order of (time, body, partner)

  std::span<const Piece> pieces_of(std::uint32_t body) const {
    return std::span(pieces).subspan(tracks[body].first, tracks[body].count);
  }
};
bool operator==(const Entry& a, const Entry& b);

/// A number that every animation has, such as "log_prior", "landing_m" or "upper_face[2]".
struct NumberName {
  std::string name{};
  std::string unit{};  ///< such as "m"; "1": no unit
  friend bool operator==(const NumberName&, const NumberName&) = default;
};

/// Positions of the numbers that every index has, before the world's own numbers.
inline constexpr std::size_t k_log_prior = 0;
inline constexpr std::size_t k_log_constraint = 1;
inline constexpr std::size_t k_chain = 2;
inline constexpr std::size_t k_draw = 3;
inline constexpr std::size_t k_lineage = 4;
inline constexpr std::size_t k_rest_s = 5;
inline constexpr std::size_t k_events = 6;
inline constexpr std::size_t k_in_proportion = 7;
inline constexpr std::size_t k_own_numbers = 8;

/// Returns the names of the numbers that every index has. rest_s is the time when the last body
/// came to rest; in_proportion is 0 or 1.
const std::vector<NumberName>& own_numbers();

struct Index {
  std::string run_id{};
  std::string digest{};  ///< as stored in the archive that was read
  std::string world{};
  scene::Scene scene{};
  std::vector<NumberName> numbers{};
  std::vector<Entry> entries{};
};

/// Returns the last piece that began at or before t_s; null before the first.
const Piece* piece_at(std::span<const Piece> pieces, double t_s);
/// Returns the centre's position; nothing before the body enters. Extrapolates the last piece.
std::optional<math::Vec3> centre_at(std::span<const Piece> pieces, double t_s);

/// Sets `reach` of every track. REQUIRES: valid tracks and pieces.
void measure_reach(Entry& entry);

}  // namespace sleight::browse
