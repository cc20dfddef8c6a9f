// Proposals that change spelling animations (thesis A.2.2), and the ratios that make Algorithm 2.1
// correct.
//
// Three of the five kinds are their own reverse. disable_balls and enable_balls are each other's
// reverse, and have the same probability. So each kind, together with its reverse, preserves the
// target. Let N be the number of balls, n the number of active balls, and a the area of the drop
// region:
//
//   `change_all` draws from p_w independently of the state: log q ratio = log p_w of the present
//     state - log p_w of the candidate.
//   `change_vertices` adds an isotropic Gaussian to each vertex with a given probability;
//     symmetric.
//   `change_ball` moves an active ball's drop place. Ball and direction are uniform, and the length
//     is Gaussian. The place is wrapped at the region's edges; symmetric.
//   `disable_balls` disables each active ball with probability f. If it disables m balls, the
//     proposal has probability f^m (1-f)^(n-m). The reverse proposal has probability f^m
//     (1-f)^(N-n) a^-m. So log q ratio = (N - 2 n + m) log(1-f) - m log a.
//   `enable_balls` is the mirror image: log q ratio = (2 n - N + m) log(1-f) + m log a.
//
// If a kind finds nothing to change, it proposes the present state.
//
// The above holds for Kernel::correct. Kernel::thesis follows A.2.2 and A.2.1 as printed. It is
// biased:
//
//   `change_all` draws offsets as lengths N(0, vertex_sd) in uniform directions, although p_w
//     scores the isotropic Gaussian. The proposal counts as symmetric: log q ratio = 0. Chains
//     start with a draw by this `change_all`.
//   `change_vertices` adds a length N(0, vertex_sd) in a uniform direction; symmetric.
//   `disable_balls` has log q ratio = m log a: the thesis has a factor a for "a ball", so m balls
//     give a^m.
//   `enable_balls` has log q ratio = -m log a.
//
// So a^m and a^-m are exchanged, and the powers of 1-f are missing. The thesis kernel's results
// depend on the unit of a, here the square metre. If a is below 1, balls are enabled and hardly
// ever disabled again. In square millimetres, no ball would stay enabled.
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/bytes.h"
#include "common/math/vector.h"
#include "common/random/stream.h"
#include "worker/sampling/target.h"
#include "worker/worlds/spelling/parameters.h"

namespace sleight::worlds::spelling {

using math::Vec2;
using math::Vec3;

struct State {
  std::vector<Vec3> offsets_m;       ///< of the partition vertices
  std::vector<std::uint8_t> active;  ///< by ball: 1 if it takes part
  std::vector<Vec2> drops_m;         ///< by ball: drop place; 0 if inactive
  std::uint32_t active_count() const { return active_before(active.size()); }
  /// Number of active balls with lower numbers than `ball`.
  std::uint32_t active_before(std::size_t ball) const;
  friend bool operator==(const State&, const State&) = default;
};

enum class Kind : std::uint8_t {
  change_all,
  change_vertices,
  change_ball,
  disable_balls,
  enable_balls,
  aim_ball,  ///< see aimed_drops.h, also for scatter_ball
  scatter_ball,
  // Compound proposals. Simulations of lone balls judge these proposals before all balls are
  // simulated (solo_balls.h).
  solo_walk,  ///< several steps
  solo_step   ///< one step; it uses what is known of the state
};
inline constexpr std::uint32_t k_kinds = 9;
/// The first kinds are the thesis's kinds (A.2.2).
inline constexpr std::uint32_t k_thesis_kinds = 5;

/// The distribution p_w of the variables.
struct Prior {
  std::uint32_t vertices = 0;
  std::uint32_t balls = 0;
  double vertex_sd_m = 1;
  Vec2 drop_half_m{1, 1};  ///< half the sides of the drop region

  double log_area() const;
  /// Draws the drop place of an active ball.
  Vec2 draw_drop(random::Stream& stream) const;
  bool may_drop_at(const Vec2& drop_m) const;
  /// The log density is for lengths in metres, and normalised. Outside the region, it is -infinity.
  double log_density(const State& state) const;
};

/// Draws a chain's start. The kernel's `change_all` proposes states in the same way.
/// Kernel::correct draws from the prior.
State draw_state(const Prior& prior, Kernel kernel, random::Stream& stream);

/// Proposes a change of one kind. `scales` is by kind; if empty, all scales are 1. Scales multiply
/// the lengths by which vertices and balls move, and the probability of disabling or enabling a
/// ball. Disabling and enabling both use the scale of disable_balls. REQUIRES: the kind doesn't
/// depend on the outcome.
sampling::Proposal<State> propose_of(Kind kind, const Prior& prior,
                                     const ProposalParameters& parameters, const State& state,
                                     std::span<const double> scales, random::Stream& stream);
Kind drawn_kind(const ProposalParameters& parameters, random::Stream& stream);

/// Returns all numbers of a state: all partition vertices' offsets (x, y, z each), then 1 for each
/// active ball and 0 for each other ball, then each ball's drop place (x, y).
std::vector<double> values_of(const State& state);
/// Encodes a state as the doubles of values_of().
base::Bytes encode(const State& state);
/// Refuses a wrong length, an offset or place that isn't finite, and any activity except 0 and 1.
std::optional<State> decode(const Prior& prior, base::BytesView bytes);

inline bool has_scale(Kind kind) {
  return kind == Kind::change_vertices || kind == Kind::change_ball ||
         kind == Kind::disable_balls || kind == Kind::solo_walk;
}

}  // namespace sleight::worlds::spelling
