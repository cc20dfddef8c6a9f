// Proposals that depend on the outcome: if a ball fills no designated bin, it is dropped near an
// empty bin. The thesis has no aimed drops. The thesis's drops (A.2.2) find the last empty bin once
// in thousands of times.
//
// Aiming and scattering a ball are each other's reverse. For an animation A, let L(A) be the balls
// that fill no designated bin, R(A) the other balls, and U(A) the empty designated bins. L includes
// inactive balls. So |L| = |U| = N - |R|. The density f_b(x) of drops aimed at bin b (Windows) is
// roughly the density of drops that end in bin b. The mean of f_b over U is f_U.
//
//   `aim_ball` drops a uniform ball of L at x drawn from f_U, q = aim / |L(A)| f_U(x).
//   `scatter_ball` redraws a uniform ball of R from the prior, q = scatter / |R(A)| p_w(ball).
//
// If an aimed ball fills no bin, or if a scattered ball fills a bin, there is no reverse proposal,
// and the ratio is 0. So the ratio depends on the candidate's outcome. Before the simulation, only
// an upper bound of the ratio is known. Thread safety: pure functions, and values.
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

/// Shares of aimed drops: four squares around the bin, and the whole drop region. The squares are
/// one, three, five and seven bins wide. Drops are uniform in each. In 20,000 drops on the box of
/// ACM, lone balls that a bin caught had been dropped above the bin itself (29%), above the ring of
/// bins around it (39%), or above the next rings (20% and 8%).
inline constexpr std::array<double, 5> k_window_shares{0.24, 0.34, 0.22, 0.12, 0.08};

/// The windows of all designated bins. Bins are in the pattern's order. Windows are clipped to the
/// region in which balls are dropped.
class Windows {
 public:
  /// Adds the next bin's window. `middle_m` is the bin's middle. `half_m` has half the sides of the
  /// drop region, whose middle is the origin.
  void add(const Vec2& middle_m, double bin_m, const Vec2& half_m);
  std::size_t bins() const { return of_bin_.size(); }

  Vec2 draw(std::size_t bin, random::Stream& stream) const;
  /// Returns the mean density over the given bins, 1/m^2.
  double density(std::span<const std::size_t> bins, const Vec2& drop_m) const;
  /// Returns an upper bound of the mean density over any bins, up to rounding.
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

/// By ball: the number of the designated bin that the ball fills, or k_fills_none.
using Filling = std::vector<std::int16_t>;
inline constexpr std::int16_t k_fills_none = -1;

std::vector<std::uint8_t> full_bins(std::size_t bins, const Filling& filling);
/// Whether a bin is full. False for k_fills_none.
inline bool is_full(std::span<const std::uint8_t> full, std::int16_t bin) {
  return bin != k_fills_none && full[static_cast<std::size_t>(bin)] != 0;
}
std::vector<std::size_t> empty_bins(std::size_t bins, const Filling& filling);

/// Return a proposal whose ratio is an upper bound. Return nothing if there is no ball to move.
std::optional<sampling::Proposal<State>> aim_ball(const Prior& prior, const Windows& windows,
                                                  const ProposalParameters& parameters,
                                                  const State& state, const Filling& filling,
                                                  random::Stream& stream);
std::optional<sampling::Proposal<State>> scatter_ball(const Prior& prior, const Windows& windows,
                                                      const ProposalParameters& parameters,
                                                      const State& state, const Filling& filling,
                                                      random::Stream& stream);

/// Return the log q ratio, given the candidate's filling. If there is no reverse proposal, return
/// -infinity. The ratio of `scatter_ball` is the inverse of the reverse `aim_ball`'s ratio.
double aim_log_q_ratio(const Prior& prior, const Windows& windows,
                       const ProposalParameters& parameters, const State& state,
                       const Filling& filling, const State& candidate,
                       const Filling& candidate_filling);
double scatter_log_q_ratio(const Prior& prior, const Windows& windows,
                           const ProposalParameters& parameters, const State& state,
                           const Filling& filling, const State& candidate,
                           const Filling& candidate_filling);

}  // namespace sleight::worlds::spelling
