// Proposals that look at the outcome: a ball that fills no designated bin is dropped above one that
// is empty. Not of the thesis; A.2.2's drops find the last empty bin once in thousands of times.
//
// Two kinds, which are each other's way back. L(A) are the balls that fill no designated bin in an
// animation A, inactive ones included; U(A) the empty designated bins; both have N - k. Each
// designated bin has a window: the square of its clear side above it, as far as balls may be
// dropped there. No two windows overlap.
//
//   aim_ball      a ball of L and a bin of U, uniformly; the ball is dropped uniformly in the bin's
//                 window:          q = aim / (|L| |U| area of the window)
//   scatter_ball  one of all balls, uniformly, as the prior draws it: q = scatter / N x p_w(ball)
//
// The ratio of one hangs on the other's q out of the candidate, so that of scatter_ball on the
// candidate's outcome: it is known after the simulation, and bounded before it. It is 0 where
// aim_ball doesn't lead back.
// Thread safety: pure functions, and values.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/math/vector.h"
#include "common/random/stream.h"
#include "worker/sampling/target.h"
#include "worker/worlds/spelling/proposals.h"

namespace sleight::worlds::spelling {

/// Of each designated bin, in the order of the pattern.
struct Windows {
  std::vector<Vec2> low_m;
  std::vector<Vec2> high_m;
  std::size_t count() const { return low_m.size(); }
  double log_area(std::size_t bin) const;
  std::optional<std::size_t> above(const Vec2& drop_m) const;
};

/// By ball: the number of the designated bin that it fills, k_fills_none if none.
using Filling = std::vector<std::int16_t>;
inline constexpr std::int16_t k_fills_none = -1;

struct AimParameters {
  double aim = 0;      ///< probability of aim_ball among all kinds
  double scatter = 0;  ///< of scatter_ball
};

/// What aim_ball proposes; nothing where all bins are filled. Its ratio is exact.
std::optional<sampling::Proposal<State>> aim_ball(const Prior& prior, const Windows& windows,
                                                  const AimParameters& parameters,
                                                  const State& state, const Filling& filling,
                                                  random::Stream& stream);

/// What scatter_ball proposes. Its ratio is a bound.
sampling::Proposal<State> scatter_ball(const Prior& prior, const Windows& windows,
                                       const AimParameters& parameters, const State& state,
                                       random::Stream& stream);
/// The ratio, when it is known what the candidate fills; -infinity if there is no way back.
double scatter_log_q_ratio(const Prior& prior, const Windows& windows,
                           const AimParameters& parameters, const State& state,
                           const State& candidate, const Filling& candidate_filling);

}  // namespace sleight::worlds::spelling
