// Whether chains that all started on one side have burnt in: judged, not assumed.
//
// Chains that start from a search (stage_search.h) all lack most of what the search leaves out: it
// seldom has a ball that was helped into its bin by another one. So they agree from the first scan
// on, and R-hat, which looks at whether chains agree, is no proof by itself. What is judged is the
// second half of a tour's scans, over all chains together and none left out for how it looks:
//
//   - split R-hat of each value is at most k_burnt_in_r_hat. Means of half chains then differ by no
//     more than 0.66 standard deviations of a draw, as they do where each holds some 2.3 effective
//     draws. The scans before the judged ones are as many as these: 4.5 times as long as draws are
//     correlated, so that some 1% should be left of what the start lacked;
//   - a value that starts at one end has left it: some draw is none of the chains' starts.
//
// Source of R-hat: diagnostics/r_hat.h. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

inline constexpr double k_burnt_in_r_hat = 1.2;

/// What a world's burn-in is judged by.
struct BurnInValue {
  const char* name;
  /// It begins at one end of its values in every chain, and has others in the target: chains where
  /// it still is what it was have not burnt in.
  bool starts_at_one_end = false;
};

/// What is said of one value.
struct ValueVerdict {
  double r_hat = 0;  ///< NaN where all draws are equal
  bool passes = false;
};

/// `draws` are of a tour's second half; `starts` are the chains' values before any step.
ValueVerdict judge_value(const BurnInValue& value, std::span<const double> starts,
                         const Chains& draws);

}  // namespace sleight::sampling
