// Moves of a chain over a scene's states. Each keeps the prior invariant.
//
//   redraw   a block of numbers afresh: all (and the noise's key), one body's, or one draw's
//   step     a block mixes old and new: z' = sqrt(1 - s^2) z + s xi for normals, and a reflected
//            normal step of size s / 2 for uniforms
//   shot     one of the N noised impacts, chosen evenly, takes such a step; ratio N / N'
//   tail     the noise of all impacts from a random time on is drawn afresh, by a new key
//
// What happened before a shot or a tail stays, so the reverse move can choose the same impact or
// time. A tail that begins after the last impact renews the noise that no impact has used; so there
// are at most as many overrides as impacts, and those that shots have added since.
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "common/random/stream.h"
#include "worker/physics/contact/impacts.h"
#include "worker/sampling/target.h"
#include "worker/worlds/user_scene/state.h"

namespace sleight::worlds::user_scene {

/// The kinds of moves, in this order. Steps and shots have a scale.
enum class Kind : std::uint8_t {
  redraw_all,
  redraw_body,
  redraw_draw,
  step_all,
  step_body,
  step_draw,
  shot,
  tail
};
/// Scenes without noise have only the first kinds.
inline constexpr std::uint32_t k_move_kinds = 8;
inline constexpr std::uint32_t k_move_kinds_without_noise = 6;

struct MoveChoices {
  const Quantities& quantities;
  bool has_noise = false;
  double end_s = 0;                         ///< tails begin before this, or change no used noise
  std::span<const physics::Impact> noised;  ///< of the present state's simulation
};

/// Proposes a candidate. `scales`: factors of the kinds' steps, or empty. A shot's ratio waits for
/// the candidate's impacts (shot_log_ratio).
sampling::Proposal<State> propose(const MoveChoices& choices, const State& state,
                                  std::span<const double> scales, random::Stream& stream);

/// Returns log N / N'.
double shot_log_ratio(std::span<const physics::Impact> noised,
                      std::span<const physics::Impact> candidate_noised);

/// Steps the noise of an impact by sqrt(1 - s^2) x + s xi.
void step_noise(NoiseState& noise, const physics::NoiseAddress& address, double step,
                random::Stream& stream);

/// Returns the noise with fresh values from a tick on.
NoiseState with_fresh_tail(const NoiseState& noise, std::span<const physics::Impact> noised,
                           physics::Tick from, random::Stream& stream);

/// Returns a step of a random size: k_step halved 0 to 5 times.
double random_step(double scale, random::Stream& stream);

}  // namespace sleight::worlds::user_scene
