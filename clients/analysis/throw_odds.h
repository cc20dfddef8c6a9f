// "One throw in 3.2 million does it": what ladders estimate of the probability to satisfy, put
// together, and in words for people.
//
// Idea. Each ladder gives log P(satisfied) with a jackknife's error. On the probability scale the
// mean of the ladders is all but the largest of them, whose own error is the worst known; so the
// mean is taken of the logs. Its error is the largest of three: what the jackknife errors combine
// to, which does not see what a whole ladder missed; the standard error between ladders, which
// does, but is itself rough with few ladders; and half the variance between ladders, by which a
// mean of logs lies below the log of a mean, and which more ladders don't make smaller.
//
// Free islands need no logs averaged: each gives an unbiased estimate of P(satisfied) itself, and
// there are many (common/math/island_odds.h).
//
// Whether such an error can be trusted, odds_doubts.h says.
//
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

/// A log and its standard error, NaN where it is not known.
struct LogEstimate {
  double value = 0;
  double error = 0;
};

enum class ErrorFrom : std::uint8_t {
  unknown,       ///< neither can be had: one ladder, whose round was too short
  jackknife,     ///< within the ladders
  between,       ///< from ladder to ladder
  mean_of_logs,  ///< half the variance between ladders
  islands,       ///< from island to island
};

/// "jackknife within ladders": for people and JSON. Of weighted draws chains take the ladders'
/// place, and their weights' spread the jackknife's.
const char* name_of(ErrorFrom from, bool weighted = false);

struct CombinedEstimate {
  LogEstimate log;
  ErrorFrom error_from = ErrorFrom::unknown;
  std::size_t ladders = 0;  ///< that had a finite value: the others are left out. Of islands all
  double own_error = 0;     ///< of the mean, from the ladders' own errors; NaN where one is unknown
  double between_error = 0;  ///< of the mean, from ladder to ladder; NaN with fewer than two
};

/// `ladders` is 0, and the value NaN, where no ladder has a finite value. A ladder whose own error
/// is unknown makes the combined jackknife error unknown.
CombinedEstimate combined(std::span<const LogEstimate> ladders);

/// Of the mean of islands' estimates: `ladders` is their number, or 0 where each is 0.
CombinedEstimate combined(const math::IslandOdds& islands);

/// One throw in so many, as powers of ten: 1e400 is no double.
struct ThrowOdds {
  double log10_throws = 0;  ///< at least 0: P above 1 comes of the estimate's error alone
  double log10_low = 0;     ///< one standard error off; NaN where that is unknown
  double log10_high = 0;
};

/// `log_natural_throw`: as WorldLayout has it.
ThrowOdds odds_of(const LogEstimate& log_p_satisfied, double log_natural_throw);

/// "one throw in 3.2 million (2.1 to 4.9 million)"; "(error unknown)" where it is.
std::string in_words(const ThrowOdds& odds);

}  // namespace sleight::analysis
