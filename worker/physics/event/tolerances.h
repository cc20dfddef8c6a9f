// Every tolerance and limit of the simulator, each with its size and what breaks when it is
// changed. They belong to the model: changing one changes trajectories, and so every run.
//
// Sizes assume SI units and bodies of 1 mm to 10 m that move at up to some 100 m/s in a scene of up
// to 1 km: a double then carries positions to 1e-13 m.
#pragma once

#include <cstdint>

#include "worker/physics/event/tick.h"

namespace sleight::physics {

/// A pair touches when its gap is at most this. It keeps bodies apart by more than they move in one
/// tick (1e-7 m at 100 m/s), so a collision is noticed before they overlap and the closest features
/// are those of separate bodies. Below 1e-9, fast bodies overlap for a tick; above 1e-5, one sees
/// things float.
inline constexpr double k_touch_m = 1e-7;

/// A touching pair collides when it approaches faster than this. Two touching bodies that don't
/// collide may sink into each other at this speed: 1e-7 m in 100 s. At 1e-13 the sign of the speed
/// is rounding noise; at 1e-6, bodies sink visibly.
inline constexpr double k_approach_mps = 1e-9;

/// How much later than a whole simulated step a search may look at the next tick: bounds on gaps
/// are lowered by this many units in the last place of the coordinates, for the rounding of the gap
/// at the skipped ticks. Too small, and two searches may disagree by a tick.
inline constexpr double k_rounding_ulps = 64 * 0x1p-53;

/// Ticks that one search may examine before it gives up with a typed error: a search takes some
/// tens; a million means that a bound is wrong.
inline constexpr std::uint32_t k_examined_ticks_max = 1'000'000;

/// Where slow contacts end (scene.h), a pair that has collided does not collide again for so long,
/// unless it has come half of the way to the depth k_sink_m since: a body that others squeeze would
/// bounce between them without time passing (inelastic collapse). A pair that approaches at 0.05
/// m/s uses up half of k_touch_m in it.
inline constexpr TickCount k_refractory = TickCount{1} << 10;  // 0.95 us

/// Bodies that approach faster than this collide at once all the same: the blows of a squeeze get
/// slower soon, and this one would sink them by more than 5e-11 m in a tick.
inline constexpr double k_fast_approach_mps = 0.05;

/// Squeezed bodies overlap by hardly more than this, unless one is a hundred times heavier than the
/// other. At 0 the gaps of pairs that are squeezed for long shrink to rounding, and then each tick
/// has its collision; 1e-9 m is what bodies move in a tick at 1 m/s anyway.
inline constexpr double k_sink_m = 5e-10;

/// After so many collisions of a body at one tick, its further ones there are plastic: no
/// restitution and no least separation speed. Free bodies collide once or twice at a tick, a cradle
/// of n balls n times.
inline constexpr std::uint32_t k_elastic_at_a_tick = 64;

/// Collisions of one body in a window of 2^20 ticks (1 ms) before the simulation gives up with a
/// typed error: a ball that bounces ever lower, in a scene that doesn't say how slow contacts end.
/// Settling bodies have some thousands.
inline constexpr std::uint32_t k_collisions_in_window_max = 200'000;
inline constexpr TickCount k_window = TickCount{1} << 20;

/// Events of one body at one tick before the simulation gives up with a typed error.
inline constexpr std::uint32_t k_events_at_a_tick_max = 10'000;

}  // namespace sleight::physics
