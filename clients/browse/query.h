// Queries select animations of an index. Queries are exact: paths are solved, not sampled.
//
// The command line and the gallery accept the same syntax:
//
//   `die 3 in x 0..20mm y -5..5mm during 0.4..0.6s`: die 3's centre is in the box at some moment of
//     this interval.
//   `any in z 30mm..`: some body's centre is in the box at some time.
//   `every ends in x -100..100mm`: each body rests in the box.
//   `die 1 touches table during ..0.2s`: the two hit each other in this interval.
//   `die 1 touches table then die 1 touches die 2`: two hits in this order.
//   `log_prior -30..-20`, `bounces = 3`, `upper_face[1] >= 2`, `landing_m < 5cm`: numbers.
//   `then`, `not`, `and`, `or`, `( )`: combinations, from strongest to weakest.
//
// With `then`, each step holds at its earliest moment after the previous step. A body or thing has
// its name in the scene description ("die 3", "table"). Names with other characters than letters
// and digits need double quotes. `any` (or `any body`) and `every` stand for all bodies; `any die`
// stands for the bodies called "die N". `die 3: x ...` means `die 3 in x ...`. Ranges include both
// ends; one end may be omitted.
//
// Numbers without a unit are SI. The units are um, mm, cm, m; us, ms, s; deg, rad; mm/s, m/s. If
// only one end of a range has a unit, the unit applies to both ends. Without `during`, any moment
// counts, even after a body came to rest. Before a body enters, it is in no box. `every` ignores
// bodies that never enter. Thread safety: values; const functions may be called from several
// threads at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "clients/browse/index.h"
#include "clients/browse/inside.h"
#include "common/base/result.h"

namespace sleight::browse {

/// Maximum length and nesting of a query.
inline constexpr std::size_t k_query_bytes_max = 20'000;
inline constexpr std::size_t k_query_depth_max = 100;

/// Bodies of a scene, ascending. A condition must hold for one of the bodies, or for every body.
struct Bodies {
  std::vector<std::uint32_t> bodies{};
  bool is_every = false;
};

struct Inside {
  Bodies who{};
  Box box{};
  Stretch when{};
};

struct Touches {
  Bodies who{};
  /// Scene features, ascending. None: any partner.
  std::vector<std::uint32_t> partners{};
  Stretch when{};
};

struct EndsIn {
  Bodies who{};
  Box box{};
};

struct NumberIn {
  std::size_t number = 0;  ///< index into Index::numbers
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool is_low_open = false;
  bool is_high_open = false;
};

struct Condition;

/// Conditions that must hold one after another: Inside, Touches.
struct InOrder {
  std::vector<Condition> steps;
};
struct AllOf {
  std::vector<Condition> parts;
};
struct AnyOf {
  std::vector<Condition> parts;
};
struct Not {
  std::vector<Condition> part;  ///< one
};

struct Condition {
  std::variant<Inside, Touches, EndsIn, NumberIn, InOrder, AllOf, AnyOf, Not> is{};
};

struct QueryError {
  std::size_t column = 0;  ///< of the first wrong byte, from 0
  std::string message{};
};
/// Returns three lines: the message, the text, and a mark below the column.
std::string with_mark(const QueryError& error, std::string_view text);

/// Parses a query for an index with this scene and these numbers.
base::Result<Condition, QueryError> parse_query(std::string_view text, const scene::Scene& scene,
                                                const std::vector<NumberName>& numbers);

/// Whether the animation matches. REQUIRES: the condition was parsed for this entry's scene and
/// numbers.
bool is_met(const Condition& condition, const Entry& entry);

/// Returns the matching entries, ascending.
std::vector<std::size_t> find(const Condition& condition, const Index& index);

}  // namespace sleight::browse
