// The last partners that each body collided with, and the gaps then: for the refractory time
// (tolerances.h).
//
// Thread safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/event/ids.h"
#include "worker/physics/event/tick.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {

/// Until when a pair collides only at a smaller gap.
struct Refractory {
  Tick until{};  ///< in the past: no longer
  double touch_m = k_touch_m;
};

/// One look at a pair that may be refractory: examine(touch) judges the tick.
template <class Examine>
Examined examined_at(Tick tick, const Refractory& refractory, const Examine& examine) {
  if (tick >= refractory.until) return examine(k_touch_m);
  const Examined examined = examine(refractory.touch_m);
  if (examined.collides || examined.next <= refractory.until) return examined;
  return {.collides = false, .next = refractory.until};  // from then on, any touch counts again
}

class RecentContacts {
 public:
  /// Bodies have no contacts. With 0 bodies there is no refractory time.
  void reset(std::size_t bodies) { of_body_.assign(bodies, {}); }
  bool enabled() const { return !of_body_.empty(); }

  /// More than a body has neighbours that press on it within a microsecond.
  static constexpr std::size_t k_partners = 16;
  /// A collision with a partner.
  struct Entry {
    BodyId partner{UINT32_MAX};
    Tick tick{-1};
    double gap_m = 0;
  };
  /// Appends all that is known of a body, for a simulation that goes on from here; how much.
  std::size_t remember(BodyId body, std::vector<Entry>& entries) const {
    if (!enabled()) return 0;
    const std::size_t before = entries.size();
    std::ranges::copy_if(of_body_[body].entries, std::back_inserter(entries),
                         [](const Entry& entry) { return entry.partner != UINT32_MAX; });
    return entries.size() - before;
  }
  void restore(BodyId body, std::span<const Entry> entries) {
    if (!enabled()) return;
    of_body_[body] = {};
    std::ranges::copy(entries, of_body_[body].entries.begin());
  }

  /// A collision of a body with a partner. Whether both are noted is the caller's choice.
  void note(BodyId body, BodyId partner, Tick tick, double gap_m) {
    if (!enabled()) return;
    Ring& ring = of_body_[body];
    std::size_t place = 0;
    for (std::size_t i = 0; i < k_partners; ++i) {
      if (ring.entries[i].partner == partner) {
        place = i;
        break;
      }
      if (ring.entries[i].tick < ring.entries[place].tick) place = i;
    }
    ring.entries[place] = {.partner = partner, .tick = tick, .gap_m = gap_m};
  }

  Refractory of(BodyId body, BodyId partner) const {
    if (!enabled()) return {};
    for (const Entry& entry : of_body_[body].entries) {
      if (entry.partner != partner) continue;
      // Half of the way to k_sink_m, but not by less than distances are good for.
      const double left_m = std::max(entry.gap_m + k_sink_m, k_sink_step_m_min);
      return {.until = entry.tick + k_refractory, .touch_m = entry.gap_m - 0.5 * left_m};
    }
    return {};
  }

 private:
  struct Ring {
    std::array<Entry, k_partners> entries;
  };
  std::vector<Ring> of_body_;
};

}  // namespace sleight::physics
