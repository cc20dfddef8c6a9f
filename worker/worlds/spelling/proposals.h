// How spelling animations are changed (thesis A.2.2), with the ratios that make Algorithm 2.1
// right.
//
// Each of the five kinds is its own reverse, but for disabling and enabling, which are one
// another's and have the same probability. So each pair of kinds keeps the target by itself. With N
// balls of which n are active and a the area that they are dropped from:
//
//   change_all       a draw from p_w, whatever the state was: log q ratio = log p_w of the present
//                    state less that of the candidate
//   change_vertices  each with a probability: plus an isotropic Gaussian; symmetric
//   change_ball      one active ball, uniformly: its drop place, in a uniform direction, by a
//                    Gaussian length, wrapped at the region's edges; symmetric
//   disable_balls    each active ball with probability f: of m disabled ones, the way there has the
//                    probability f^m (1-f)^(n-m), the way back f^m (1-f)^(N-n) a^-m, so
//                    log q ratio = (N - 2 n + m) log(1-f) - m log a
//   enable_balls     its mirror image: log q ratio = (2 n - N + m) log(1-f) + m log a
//
// A kind that finds nothing to change proposes the present state.
//
// All this is Kernel::correct. Kernel::thesis does what A.2.2 and A.2.1 print, which is biased:
//
//   change_all       offsets are lengths N(0, vertex_sd) in uniform directions, though p_w scores
//                    the isotropic Gaussian; taken for symmetric, log q ratio = 0. Chains start
//                    from such a draw
//   change_vertices  plus a length N(0, vertex_sd) in a uniform direction; symmetric
//   disable_balls    log q ratio = m log a: the text has a for "a ball", so a^m for m of them
//   enable_balls     log q ratio = -m log a
//
// so a^m and a^-m are the other way round, and there are no powers of 1-f. Its results depend on
// the unit of a, which is the square metre here: with a below 1 balls are brought in and hardly
// taken out again. In square millimetres it would leave no ball.
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/math/vector.h"
#include "common/random/stream.h"
#include "worker/sampling/target.h"
#include "worker/worlds/spelling/parameters.h"

namespace sleight::worlds::spelling {

using math::Vec2;
using math::Vec3;

/// What is uncertain of an animation.
struct State {
  std::vector<Vec3> offsets_m;       ///< of the partition vertices
  std::vector<std::uint8_t> active;  ///< by ball: 1 if it takes part
  std::vector<Vec2> drops_m;         ///< by ball: where it is dropped; 0 if it isn't
  std::uint32_t active_count() const { return active_before(active.size()); }
  /// Of those with a lower number.
  std::uint32_t active_before(std::size_t ball) const;
  friend bool operator==(const State&, const State&) = default;
};

enum class Kind : std::uint8_t {
  change_all,
  change_vertices,
  change_ball,
  disable_balls,
  enable_balls,
  aim_ball,  ///< of aimed_drops.h, as the next
  scatter_ball,
  // Of others that are judged by balls that fall alone (solo_balls.h), when all are simulated.
  solo_walk,  ///< several
  solo_step   ///< one, with what is known of the state
};
inline constexpr std::uint32_t k_kinds = 9;
/// Those of A.2.2: the first.
inline constexpr std::uint32_t k_thesis_kinds = 5;

/// The variables' distribution: p_w.
struct Prior {
  std::uint32_t vertices = 0;
  std::uint32_t balls = 0;
  double vertex_sd_m = 1;
  Vec2 drop_half_m{1, 1};  ///< half the sides of the region that balls are dropped from

  double log_area() const;
  State draw(random::Stream& stream) const;
  /// Where an active ball is dropped.
  Vec2 draw_drop(random::Stream& stream) const;
  /// Whether it may be dropped there.
  bool may_drop_at(const Vec2& drop_m) const;
  /// Normalised, with respect to lengths in metres; -infinity outside of the region.
  double log_density(const State& state) const;
};

/// What a chain of this kernel starts from, and what its change_all proposes. For Kernel::correct
/// it is prior.draw(stream).
State draw_state(const Prior& prior, Kernel kernel, random::Stream& stream);

/// `scales`: by kind, or empty for 1; of the lengths by which vertices and balls move, and of the
/// probability with which a ball is disabled, or enabled: both have the scale of disable_balls.
/// REQUIRES: the kinds that look at the outcome have no share.
sampling::Proposal<State> propose(const Prior& prior, const ProposalParameters& parameters,
                                  const State& state, std::span<const double> scales,
                                  random::Stream& stream);
/// One of a kind that doesn't look at the outcome.
sampling::Proposal<State> propose_of(Kind kind, const Prior& prior,
                                     const ProposalParameters& parameters, const State& state,
                                     std::span<const double> scales, random::Stream& stream);
Kind drawn_kind(const ProposalParameters& parameters, random::Stream& stream);
inline sampling::Proposal<State> propose(const Prior& prior, const ProposalParameters& parameters,
                                         const State& state, random::Stream& stream) {
  return propose(prior, parameters, state, {}, stream);
}

/// Whether a kind's proposals have a size.
inline bool has_scale(Kind kind) {
  return kind == Kind::change_vertices || kind == Kind::change_ball ||
         kind == Kind::disable_balls || kind == Kind::solo_walk;
}

}  // namespace sleight::worlds::spelling
