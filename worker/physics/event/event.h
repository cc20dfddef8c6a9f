// The events of a simulation, and their order.
//
// Events are totally ordered by (tick, kind, lower id, higher id, feature); no two waiting events
// have the same key. Processing at one tick:
//
//   repeat
//     e = the least of all waiting events
//     process e: it may change bodies, which removes and adds events, also at this same tick
//   until the least event is later.
//
// So an event at tick t uses the state left by earlier events at t. For example, if two balls hit a
// third at the same tick, the pair with the lower ids is resolved first, and the other pair is
// tested again with the third ball's new velocity. The order doesn't depend on which body predicted
// an event, or when. Thread safety: values.
#pragma once

#include <compare>
#include <cstdint>

#include "worker/physics/event/ids.h"
#include "worker/physics/event/tick.h"

namespace sleight::physics {

/// Kinds in the order in which they are processed at one tick. `update` changes no state, only
/// which pairs are watched; it precedes all other events of such pairs at that tick. `sample`
/// observes the state after all other events.
enum class EventKind : std::uint8_t { update, control, start, collision, mode, rest, sample };

/// Marks the other id in an event's key as static geometry.
inline constexpr std::uint32_t k_static = std::uint32_t{1} << 31U;

/// The order of events. Events of a single body leave `higher` and `feature` at 0 if unused.
struct EventKey {
  Tick tick = k_never;
  EventKind kind = EventKind::update;
  std::uint32_t lower = 0;    ///< id of the first body
  std::uint32_t higher = 0;   ///< id of the other body, or index of a static piece
  std::uint32_t feature = 0;  ///< which of several contacts of the pair
  /// REQUIRES for each function below: this kind of event has the value that the function returns.
  constexpr BodyId body() const { return {lower}; }
  constexpr BodyId other_body() const { return {higher}; }
  constexpr bool is_with_static() const { return (higher & k_static) != 0; }
  constexpr StaticId met() const { return {higher & ~k_static}; }
  friend constexpr auto operator<=>(const EventKey&, const EventKey&) = default;
};

/// A key later than all others, for events that never happen.
inline constexpr EventKey k_no_event{.tick = k_never,
                                     .kind = EventKind::sample,
                                     .lower = UINT32_MAX,
                                     .higher = UINT32_MAX,
                                     .feature = UINT32_MAX};

}  // namespace sleight::physics
