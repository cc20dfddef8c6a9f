// Stores each body's last collision partners, and the gap at each collision. The refractory time
// (tolerances.h) uses them.
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

/// Until a tick, a pair collides only if its gap is smaller than usual.
struct Refractory {
  Tick until{};  ///< in the past: no restriction
  double touch_m = k_touch_m;
};

/// Examines a pair that may be refractory. examine(touch_m) must examine one tick.
template <class Examine>
Examined examined_at(Tick tick, const Refractory& refractory, const Examine& examine) {
  if (tick >= refractory.until) return examine(k_touch_m);
  const Examined examined = examine(refractory.touch_m);
  if (examined.collides || examined.next <= refractory.until) return examined;
  return {.collides = false, .next = refractory.until};  // after that, any touch counts again
}

class RecentContacts {
 public:
  /// Clears all contacts. If `bodies` is 0, there is no refractory time.
  void reset(std::size_t bodies) { of_body_.assign(bodies, {}); }
  bool enabled() const { return !of_body_.empty(); }

  /// Maximum stored partners of a body. Fewer partners than this can press on a body within a
  /// microsecond.
  static constexpr std::size_t k_partners = 16;
  struct Entry {
    BodyId partner{UINT32_MAX};
    Tick tick{-1};
    double gap_m = 0;
  };
  /// Appends a body's entries. A simulation needs them to resume from here. Returns their number.
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

  /// Records a collision for one body. The caller decides whether the partner also records it.
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
      // The next collision's gap is smaller: by half of the distance left to k_sink_m, where this
      // distance counts as at least k_sink_step_m_min.
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
