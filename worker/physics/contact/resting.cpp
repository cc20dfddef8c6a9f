#include "worker/physics/contact/resting.h"

#include <algorithm>

#include "common/math/vector.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/motion/rotation_bounds.h"

namespace sleight::physics {

Contacts Resting::carrying(std::span<const TouchRecord> contacts, const Present& state,
                           TickCount slow) const {
  const bool anyhow = state.round || slow / k_patience >= rest_span();
  return physics::carrying(contacts, state.weight_n, state.reach_m, !anyhow);
}

void Resting::note_stay(Log& log, Tick now) const {
  const double moved_m = math::norm(log.state.centre_m - log.stays_at_m);
  if (log.candidate && log.stays_since <= now && log.stays_since >= log.slow_since &&
      moved_m <= k_in_place * log.state.reach_m)
    return;
  log.stays_since = log.candidate ? now : k_never;
  log.stays_at_m = log.state.centre_m;
}

bool Resting::has_stayed(const Log& log, Tick now) const {
  return log.stays_since <= now && (now - log.stays_since) / k_patience >= rest_span();
}

bool Resting::has_been_slow(const Log& log, Tick now) const {
  return log.slow_since <= now && (now - log.slow_since) / k_patience >= rest_span();
}

Contacts Resting::supporting(const Log& log, Tick now) const {
  const TickCount slow = now - log.slow_since;
  const auto contacts = log.touches();
  if (log.state.stance == Stance::slides && !has_stayed(log, now)) return 0;
  const bool weightless = is_zero(log.state.weight_n);
  const auto pushes_up = [&](const TouchRecord& touch) {
    return weightless || math::dot(touch.normal, log.state.weight_n) < 0;
  };
  // Without a weight that could be balanced, on all that may carry it.
  if (weightless || is_jammed(log) || has_stayed(log, now) || log.state.stance == Stance::holds) {
    Contacts all = 0;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (!pushes_up(contacts[k])) continue;
      if (!may_lean_on(contacts[k])) return 0;
      all |= Contacts{1} << k;
    }
    return all;
  }
  // On those that push it up, if they suffice, so that what lies on it doesn't hold it; else with
  // the others.
  std::array<TouchRecord, k_touch_records_max> chosen;
  std::array<std::size_t, k_touch_records_max> places;
  std::size_t before = 0;
  for (const bool any : {false, true}) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (!may_lean_on(contacts[k]) || !(any || pushes_up(contacts[k]))) continue;
      chosen[count] = contacts[k];
      places[count++] = k;
    }
    if (count == before) continue;
    before = count;
    const Contacts pushing =
        carrying(std::span<const TouchRecord>(chosen).first(count), log.state, slow);
    Contacts result = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if ((pushing >> i & 1U) != 0) result |= Contacts{1} << places[i];
    }
    if (result != 0) return result;
  }
  return 0;
}

bool Resting::balances(std::size_t count, Tick now) {
  held_bodies_.clear();
  holding_.clear();
  for (std::size_t i = 0; i < structure_.size(); ++i) {
    Log& log = logs_[structure_[i]];
    log.structure_place = HoldingContact::k_fixed;
    if (i >= count || is_zero(log.state.weight_n) || holds_anyhow(log, now)) continue;
    log.structure_place = static_cast<std::uint32_t>(held_bodies_.size());
    held_bodies_.push_back({.weight_n = log.state.weight_n, .reach_m = log.state.reach_m});
  }
  for (const BodyId member : structure_) {
    const Log& log = logs_[member];
    if (log.structure_place == HoldingContact::k_fixed) continue;
    for (const TouchRecord& touch : log.rests ? log.holding() : log.touches()) {
      if (!log.rests && !may_lean_on(touch)) continue;
      HoldingContact contact{.body = log.structure_place,
                             .friction = touch.friction,
                             .normal = touch.normal,
                             .arm_m = touch.arm_m};
      if (touch.partner != k_static_partner && logs_[touch.partner].in_structure == structures_) {
        const Log& partner = logs_[touch.partner];
        contact.partner = partner.structure_place;
        contact.partner_arm_m = (log.state.centre_m + touch.arm_m) - partner.state.centre_m;
      }
      holding_.push_back(contact);
    }
  }
  return balance_.holds(held_bodies_, holding_);
}

void Resting::reset(std::size_t bodies, const SlowContacts& rule, TickCount jam_span) {
  rule_ = rule;
  jam_span_ = std::min(jam_span, rest_span());
  // Not assign: most of a log are places for touches, which needn't be empty.
  logs_.resize(enabled() ? bodies : 0);
  for (Log& log : logs_)
    log.forget();
  set_.reserve(bodies);
  if (!enabled()) return;
  const std::size_t together = std::min(bodies, k_held_together_max);
  structure_.reserve(bodies);
  overloaded_.reserve(bodies);
  held_bodies_.reserve(together);
  holding_.reserve(together * k_touch_records_max);
  balance_.reserve(together, together * k_touch_records_max);
}

double Resting::wake_speed_mps() const {
  return k_wake_over_rest * rule_.rest_speed_mps;
}

void Resting::record(Log& log, const TouchRecord& touch) const {
  // The newest of each place of a partner; else in the place of the oldest.
  std::size_t place = log.count;
  const double near_m = k_same_place * math::norm(touch.arm_m);
  for (std::size_t i = 0; i < log.count; ++i) {
    const TouchRecord& other = log.records[i];
    if (other.partner == touch.partner && math::norm(other.arm_m - touch.arm_m) < near_m &&
        math::dot(other.normal, touch.normal) > 0.9) {
      place = i;
      break;
    }
  }
  if (place == k_touch_records_max) {
    place = 0;
    for (std::size_t i = 1; i < k_touch_records_max; ++i) {
      if (log.records[i].tick < log.records[place].tick) place = i;
    }
  } else if (place == log.count) {
    ++log.count;
  }
  log.records[place] = touch;
}

bool Resting::is_slow(double before_mps, double after_mps, double parting_mps) const {
  return before_mps < rule_.rest_speed_mps && after_mps < rule_.rest_speed_mps &&
         parting_mps <= k_slow_parting * rule_.separation_speed_mps;
}

void Resting::touched(BodyId body, const TouchRecord& touch, bool slowly) {
  if (!enabled()) return;
  Log& log = logs_[body];
  log.rests = false;
  record(log, touch);
  if (!slowly) {
    log.slow_since = k_never;
    log.due = due_if_not_slow(log, touch.tick);
    log.slow_collisions = 0;
    return;
  }
  if (log.slow_since > touch.tick) {  // not slow yet
    log.slow_since = touch.tick;
    log.due = touch.tick + rest_span();
  }
  if (log.slow_collisions == 0 || touch.tick - log.counted_since > jam_span_) {
    log.slow_collisions = 0;
    log.counted_since = touch.tick;
  }
  if (++log.slow_collisions % k_slow_collisions == 0) log.due = touch.tick;
}

void Resting::stays(BodyId body, Tick now, Tick slow_from) {
  if (!enabled()) return;
  Log& log = logs_[body];
  log.rests = false;
  if (slow_from > now || log.slow_since > now) log.slow_since = slow_from;
  log.due = log.slow_since == k_never ? k_never : std::max(log.slow_since + rest_span(), now);
  if (log.in_place) log.due = std::min(log.due, now + rest_span());
}

void Resting::flies(BodyId body, Tick now) {
  if (!enabled()) return;
  Log& log = logs_[body];
  if (log.slow_since <= now) return;
  log.slow_since = k_never;
  log.due = due_if_not_slow(log, now);
}

void Resting::disturbed(BodyId body) {
  if (!enabled()) return;
  Log& log = logs_[body];
  log.rests = false;
  log.slow_since = k_never;
  log.due = k_never;
  log.slow_collisions = 0;
}

std::span<const TouchRecord> Resting::recent(Log& log, Tick now) const {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < log.count; ++i) {
    if (now - log.records[i].tick <= rest_span()) log.records[kept++] = log.records[i];
  }
  log.count = kept;
  return {log.records.data(), log.count};
}

std::span<const BodyId> Resting::wake(BodyId body) {
  set_.clear();
  if (!enabled()) return set_;
  for (BodyId other{}; other < logs_.size(); ++other) {
    Log& log = logs_[other];
    if (!log.rests || !log.leans_on(body)) continue;
    log.rests = false;
    set_.push_back(other);
  }
  return set_;
}

void Resting::lies(BodyId body, std::span<const TouchRecord> touches,
                   std::span<const BodyId> supporters) {
  Log& log = logs_[body];
  log.rests = true;
  log.held_count = static_cast<std::uint32_t>(touches.size());
  std::ranges::copy(touches, log.held.begin());
  log.supporter_count = static_cast<std::uint32_t>(supporters.size());
  std::ranges::copy(supporters, log.supporters.begin());
}

void Resting::woke(BodyId body, Tick now, const Pose& pose) {
  Log& log = logs_[body];
  log.in_place = true;
  // Places don't creep: the first one counts, as long as those that rested on it may still do so.
  if (!log.has_place) log.place = pose;
  log.has_place = true;
  log.slow_since = now;
  log.due = now + rest_span();
}

bool Resting::has_left(BodyId body, const Pose& pose, double speed_mps, double reach_m) const {
  if (speed_mps >= rule_.rest_speed_mps) return true;
  return moved_m_max(logs_[body].place, pose, reach_m) > k_in_place * reach_m;
}

}  // namespace sleight::physics
