// Queries: which animations of an index are meant. They are exact: paths are solved, not sampled.
//
// The text of a query, the same on the command line and in the gallery:
//
//   die 3 in x 0..20mm y -5..5mm during 0.4..0.6s     its centre is in the box at some moment then
//   any in z 30mm..                                   some body's is, ever
//   every ends in x -100..100mm                       where each body rests
//   die 1 touches table during ..0.2s                 a recorded hit of the two
//   die 1 touches table then die 1 touches die 2      in this order; then the first box, hit, ...
//   log_prior -30..-20    bounces = 3    upper_face[1] >= 2    landing_m < 5cm
//   then, not, and, or; ( )                           in the order of their strength
//
// A body or thing is called what the scene calls it ("die 3", "table"); in double quotes where the
// name has other signs than letters and digits. `any` and `every` stand for all bodies (so does
// `any body`), `any die` for those called "die N". `die 3: x ...` says the same as `die 3 in x
// ...`. Ranges have both their ends; one may be left out. Numbers are SI where no unit is said: um,
// mm, cm, m; us, ms, s; deg, rad; mm/s, m/s; a unit behind the range is of both ends. Without
// `during` any moment counts, also after a body has come to rest; before it enters it is nowhere.
// `every` speaks of bodies that enter.
//
// Thread safety: values; const functions may be called from several threads at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "clients/browse/index.h"
#include "clients/browse/inside.h"
#include "common/base/result.h"

namespace sleight::browse {

/// Longest text, and deepest nesting of a query.
inline constexpr std::size_t k_query_bytes_max = 20'000;
inline constexpr std::size_t k_query_depth_max = 100;

/// Bodies of a scene, ascending: one of them must do what is asked, or each.
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
  /// Features, ascending; none: whatever it is.
  std::vector<std::uint32_t> partners{};
  Stretch when{};
};

struct EndsIn {
  Bodies who{};
  Box box{};
};

struct NumberIn {
  std::size_t number = 0;  ///< along Index::numbers
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool is_low_open = false;
  bool is_high_open = false;
};

struct Condition;

/// Conditions that come one after another: Inside, Touches.
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

/// What is wrong with a query's text, and where.
struct QueryError {
  std::size_t column = 0;  ///< of the first byte that is wrong, from 0
  std::string message{};
};
/// The message, the text, and a mark beneath the column: three lines.
std::string with_mark(const QueryError& error, std::string_view text);

/// The meaning of a text for an index of this scene and these numbers.
base::Result<Condition, QueryError> parse_query(std::string_view text, const scene::Scene& scene,
                                                const std::vector<NumberName>& numbers);

/// True if the animation is meant. REQUIRES: a condition for this entry's scene and numbers.
bool is_met(const Condition& condition, const Entry& entry);

/// The entries that are meant, ascending.
std::vector<std::size_t> find(const Condition& condition, const Index& index);

}  // namespace sleight::browse
