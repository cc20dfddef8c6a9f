// Proposals that look at the outcome: a ball that fills no designated bin is dropped about one that
// is empty. Not of the thesis; A.2.2's drops find the last empty bin once in thousands of times.
//
// Two kinds, which are each other's way back. In an animation A, L(A) are the balls that fill no
// designated bin, inactive ones included, R(A) those that fill one, and U(A) the empty designated
// bins; |L| = |U| = N - |R|. f_b(x) is the density of drops aimed at bin b (Windows), about that of
// where the balls come from that the bin catches; f_U its mean over U.
//
//   aim_ball      a ball of L, uniformly, is dropped at x by f_U: q = aim / |L(A)| f_U(x)
//   scatter_ball  a ball of R, uniformly, as the prior draws it:  q = scatter / |R(A)| p_w(ball)
//
// Of a ball that is aimed and fills no bin there is no way back, nor of one that is scattered and
// fills one: the ratio is 0. So the ratio hangs on the candidate's outcome: it is known after the
// simulation, and bounded before it.
// Thread safety: pure functions, and values.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/math/vector.h"
#include "common/random/stream.h"
#include "worker/sampling/target.h"
#include "worker/worlds/spelling/proposals.h"

namespace sleight::worlds::spelling {

/// Where drops are aimed: with such shares uniformly in squares about the bin, one, three, five and
/// seven bins wide, and anywhere. Of balls that fall alone a bin catches 29% from above itself, 39%
/// from the ring of bins about it, 20% and 8% from the next ones (20,000 drops on the box of ACM).
inline constexpr std::array<double, 5> k_window_shares{0.24, 0.34, 0.22, 0.12, 0.08};

/// Of each designated bin, in the order of the pattern. A square is cut off where no ball is
/// dropped.
class Windows {
 public:
  /// The next bin's, by its middle. `half_m`: half the sides of the region that balls are dropped
  /// from, about the origin.
  void add(const Vec2& middle_m, double bin_m, const Vec2& half_m);
  std::size_t bins() const { return of_bin_.size(); }

  Vec2 draw(std::size_t bin, random::Stream& stream) const;
  /// The mean of these bins' densities there, 1/m^2.
  double density(std::span<const std::size_t> bins, const Vec2& drop_m) const;
  /// No mean is greater, but for rounding.
  double greatest_density(const Vec2& drop_m) const;

 private:
  struct Window {
    Vec2 low_m{0, 0};
    Vec2 high_m{0, 0};
    double density_pm2 = 0;  ///< share / area
  };
  double density(std::size_t bin, const Vec2& drop_m) const;

  std::vector<std::array<Window, k_window_shares.size()>> of_bin_;
};

/// By ball: the number of the designated bin that it fills, k_fills_none if none.
using Filling = std::vector<std::int16_t>;
inline constexpr std::int16_t k_fills_none = -1;

/// By designated bin: 1 if a ball fills it.
std::vector<std::uint8_t> full_bins(std::size_t bins, const Filling& filling);
/// Of a bin by its number; no bin is not full.
inline bool is_full(std::span<const std::uint8_t> full, std::int16_t bin) {
  return bin != k_fills_none && full[static_cast<std::size_t>(bin)] != 0;
}
/// The numbers of the others.
std::vector<std::size_t> empty_bins(std::size_t bins, const Filling& filling);

struct AimParameters {
  double aim = 0;      ///< probability of aim_ball among all kinds
  double scatter = 0;  ///< of scatter_ball
};

/// What these propose; nothing where there is no such ball. Their ratios are bounds.
std::optional<sampling::Proposal<State>> aim_ball(const Prior& prior, const Windows& windows,
                                                  const AimParameters& parameters,
                                                  const State& state, const Filling& filling,
                                                  random::Stream& stream);
std::optional<sampling::Proposal<State>> scatter_ball(const Prior& prior, const Windows& windows,
                                                      const AimParameters& parameters,
                                                      const State& state, const Filling& filling,
                                                      random::Stream& stream);

/// log of aim_ball's ratio, when it is known what the candidate fills; -infinity if there is no way
/// back. That of scatter_ball is its inverse, from the candidate to the state.
double aim_log_q_ratio(const Prior& prior, const Windows& windows, const AimParameters& parameters,
                       const State& state, const Filling& filling, const State& candidate,
                       const Filling& candidate_filling);
double scatter_log_q_ratio(const Prior& prior, const Windows& windows,
                           const AimParameters& parameters, const State& state,
                           const Filling& filling, const State& candidate,
                           const Filling& candidate_filling);

}  // namespace sleight::worlds::spelling
