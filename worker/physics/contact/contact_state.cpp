#include "worker/physics/contact/contact_state.h"

#include <fmt/format.h>

namespace sleight::physics {

std::string words_of_too_much(const CollisionCount& count, bool slow_contacts_end) {
  if (count.at_tick > k_events_at_a_tick_max)
    return fmt::format("more than {} collisions at one tick", k_events_at_a_tick_max);
  return fmt::format("more than {} collisions in a millisecond ({})", k_collisions_in_window_max,
                     slow_contacts_end
                         ? "the body is wedged, or squeezed by a much heavier body"
                         : "bounces never end, because the minimum separation speed is 0");
}

}  // namespace sleight::physics
