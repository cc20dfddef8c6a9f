// What happens in a simulation, and in which order.
//
// Events are totally ordered by (tick, kind, lower id, higher id, feature); no two events that are
// waiting have the same key. What happens at one tick:
//
//   repeat
//     e = the least of all events that wait
//     process e: it may change bodies, which withdraws and adds events, also at this same tick
//   until the least event is later
//
// So an event at tick t is judged by the state that the earlier ones at t left behind: of two balls
// that hit a third at the same tick, the pair with the lower ids is resolved first, and the other
// pair is looked at again with the third ball's new velocity. The order does not depend on which
// body predicted an event, or when.
// Thread safety: values.
#pragma once

#include <compare>
#include <cstdint>

#include "worker/physics/event/ids.h"
#include "worker/physics/event/tick.h"

namespace sleight::physics {

/// In the order in which they are processed at one tick. `update` changes no state, only which
/// pairs are watched; it comes before all that such pairs may do at that tick. `sample` sees the
/// state after everything else.
enum class EventKind : std::uint8_t { update, control, start, collision, mode, rest, sample };

/// Marks the other's id in an event's key as that of static geometry.
inline constexpr std::uint32_t k_static = std::uint32_t{1} << 31U;

/// The order of events. Events of a single body leave `higher` and `feature` at 0 if they don't
/// need them.
struct EventKey {
  Tick tick = k_never;
  EventKind kind = EventKind::update;
  std::uint32_t lower = 0;    ///< id of the first body
  std::uint32_t higher = 0;   ///< id of the other body, or index of a static piece
  std::uint32_t feature = 0;  ///< which of several contacts of the two
  /// The first body. REQUIRES, of these: the kind of event has what they name.
  constexpr BodyId body() const { return {lower}; }
  constexpr BodyId other_body() const { return {higher}; }
  constexpr bool is_with_static() const { return (higher & k_static) != 0; }
  constexpr StaticId met() const { return {higher & ~k_static}; }
  friend constexpr auto operator<=>(const EventKey&, const EventKey&) = default;
};

/// The key of what never happens; later than every other.
inline constexpr EventKey k_no_event{.tick = k_never,
                                     .kind = EventKind::sample,
                                     .lower = UINT32_MAX,
                                     .higher = UINT32_MAX,
                                     .feature = UINT32_MAX};

}  // namespace sleight::physics
