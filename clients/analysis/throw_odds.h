// Combines the ladders' estimates of the odds into one, and puts it into words: "one throw in 3.2
// million".
//
// Idea. Each ladder has an estimate of log P(satisfied) with a jackknife error. Logs are averaged.
// A mean of probabilities would mostly depend on the largest probability, and its error is the
// least certain. The error of the mean is the largest of three errors. The first, the combined
// jackknife error, doesn't include the states that a whole ladder missed. The second, the standard
// error between ladders, includes them but is rough if there are few ladders. The third is half the
// variance between ladders: the mean of logs is too low by this amount, and more ladders don't
// reduce it.
//
// Free islands are many, and each has an unbiased estimate of P(satisfied). So these estimates are
// averaged directly (common/math/island_odds.h).
//
// odds_doubts.h decides whether the error can be trusted.
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include "common/math/island_odds.h"

namespace sleight::analysis {

inline constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

/// A log and its standard error. NaN: unknown.
struct LogEstimate {
  double value = 0;
  double error = 0;
};

enum class ErrorFrom : std::uint8_t {
  unknown,       ///< a single ladder with a round that is too short
  jackknife,     ///< within the ladders
  between,       ///< from ladder to ladder
  mean_of_logs,  ///< half the variance between ladders
  islands,       ///< from island to island
};

/// Returns, for example, "jackknife within ladders" for people and JSON. `weighted`: the text says
/// "chains" instead of "ladders", and names the weights' spread instead of the jackknife.
const char* name_of(ErrorFrom from, bool weighted = false);

struct CombinedEstimate {
  LogEstimate log;
  ErrorFrom error_from = ErrorFrom::unknown;
  std::size_t ladders = 0;  ///< ladders with a finite value; all islands
  double own_error = 0;  ///< error of the mean from the ladders' own errors; NaN if one is unknown
  double between_error = 0;  ///< error of the mean from the spread; NaN for fewer than two
};

/// Sets `ladders` to 0 and the value to NaN if no ladder has a finite value. If any ladder's own
/// error is unknown, own_error is unknown.
CombinedEstimate combined(std::span<const LogEstimate> ladders);

/// Averages islands' estimates. Sets `ladders` to the number of islands, or to 0 if all estimates
/// are 0.
CombinedEstimate combined(const math::IslandOdds& islands);

/// Odds of one throw in 10^x. The exponents are stored, because a double can't hold 1e400.
struct ThrowOdds {
  double log10_throws = 0;  ///< at least 0: only the estimate's error leads to P above 1
  double log10_low = 0;     ///< one standard error below; NaN: unknown
  double log10_high = 0;
};

/// `log_natural_throw`: see WorldLayout.
ThrowOdds odds_of(const LogEstimate& log_p_satisfied, double log_natural_throw);

/// Returns "one throw in 3.2 million (2.1 to 4.9 million)". If the error is unknown, the
/// parentheses contain "error unknown".
std::string in_words(const ThrowOdds& odds);

}  // namespace sleight::analysis
