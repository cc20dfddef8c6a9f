// Judges whether chains that started from searches (stage_search.h) have burnt in.
//
// All these chains start without details that searches seldom produce, such as helped balls. So the
// chains agree from the first scan on, and R-hat, which measures agreement, isn't a sufficient
// test. The judge looks at all chains together, in the second half of a tour's scans. The judge
// excludes no chain for its values. The chains have burnt in if both conditions hold for each
// value:
//
//   - Split R-hat is at most k_burnt_in_r_hat. Then the standard deviation of half chains' means is
//     at most 0.66 times the standard deviation of a draw, as if a half had 2.3 independent draws.
//     So the first half lasts 4.5 correlation times, and some 1% of the start's bias should be
//     left.
//   - If all chains start at one end of the value's range, at least one draw differs from the
//     starts.
//
// Source of R-hat: diagnostics/r_hat.h. Thread safety: pure functions.
#pragma once

#include <span>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

inline constexpr double k_burnt_in_r_hat = 1.2;

/// A value by which a world's burn-in is judged.
struct BurnInValue {
  const char* name;
  /// Every chain starts at one end of the value's range. The value fails if no draw differs from
  /// the starts.
  bool starts_at_one_end = false;
};

struct ValueVerdict {
  double r_hat = 0;  ///< NaN if all draws are equal.
  bool passes = false;
};

/// Judges `draws` from the second half of a tour. `starts` holds each chain's initial value.
ValueVerdict judge_value(const BurnInValue& value, std::span<const double> starts,
                         const Chains& draws);

}  // namespace sleight::sampling
