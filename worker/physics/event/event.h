// Defines the events of a simulation and their order.
//
// Events are totally ordered by (tick, kind, lower id, higher id, feature); no two waiting events
// have the same key. Processing at one tick:
//
//   repeat
//     e = the least of all waiting events
//     process e: this may remove and add events, also at this tick
//   until the least event is later.
//
// So an event at tick t uses the state left by earlier events at t. For example, let two balls hit
// a third ball at the same tick. The pair with the lower ids is resolved first. Then the other pair
// is tested again with the third ball's new velocity. The order doesn't depend on which body
// predicted an event, or when. Thread safety: values.
#pragma once

#include <compare>
#include <cstdint>

#include "worker/physics/event/ids.h"
#include "worker/physics/event/tick.h"

namespace sleight::physics {

/// Kinds of events. At one tick, they are processed in this order. `update` changes only which
/// pairs are watched, so it comes before all other events of these pairs. `sample` observes the
/// state after all other events.
enum class EventKind : std::uint8_t { update, control, start, collision, mode, rest, sample };

/// This bit in EventKey::higher marks static geometry.
inline constexpr std::uint32_t k_static = std::uint32_t{1} << 31U;

/// Defines the order of events. An event of a single body leaves `higher` and `feature` at 0 if it
/// doesn't use them.
struct EventKey {
  Tick tick = k_never;
  EventKind kind = EventKind::update;
  std::uint32_t lower = 0;    ///< id of the first body
  std::uint32_t higher = 0;   ///< id of the other body, or index of a static piece
  std::uint32_t feature = 0;  ///< which of several contacts of the pair
  /// Each function below REQUIRES that this kind of event has the value.
  constexpr BodyId body() const { return {lower}; }
  constexpr BodyId other_body() const { return {higher}; }
  constexpr bool is_with_static() const { return (higher & k_static) != 0; }
  constexpr StaticId met() const { return {higher & ~k_static}; }
  friend constexpr auto operator<=>(const EventKey&, const EventKey&) = default;
};

/// Key of an event that never happens, later than all other keys.
inline constexpr EventKey k_no_event{.tick = k_never,
                                     .kind = EventKind::sample,
                                     .lower = UINT32_MAX,
                                     .higher = UINT32_MAX,
                                     .feature = UINT32_MAX};

}  // namespace sleight::physics
