#include "worker/physics/contact/resting.h"

#include <algorithm>

#include "worker/physics/event/tolerances.h"
#include "worker/physics/motion/rotation_bounds.h"

namespace sleight::physics {

void Resting::reset(std::span<const RestingBody> bodies, const SlowContacts& rule,
                    TickCount jam_span) {
  logs_.rule = rule;
  logs_.rest_span = ticks_after(rule.rest_time_s);
  jam_span_ = std::min(jam_span, rest_span());
  const std::size_t count = enabled() ? bodies.size() : 0;
  logs_.bodies.assign(bodies.begin(), bodies.end());
  // Don't use assign(): it would also clear the arrays of touches, the largest part of a log.
  logs_.logs.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    static_cast<RestState&>(logs_.logs[i]) = {};
    logs_.logs[i].rests = bodies[i].fixed;
  }
  decision_.reset(count);
  woken_.reserve(count);
}

double Resting::wake_speed_mps() const {
  return k_wake_over_rest * logs_.rule.rest_speed_mps;
}

bool Resting::is_slow(double before_mps, double after_mps, double parting_mps) const {
  const SlowContacts& rule = logs_.rule;
  return before_mps < rule.rest_speed_mps && after_mps < rule.rest_speed_mps &&
         parting_mps <= k_slow_parting * rule.separation_speed_mps;
}

void Resting::touched(BodyId body, const TouchRecord& touch, bool slowly) {
  if (!enabled()) return;
  RestLog& log = log_of(body);
  log.rests = false;
  log.record(touch);
  if (!slowly) {
    log.slow_since = k_never;
    log.due = due_if_not_slow(log, touch.tick);
    log.slow_collisions = 0;
    return;
  }
  if (log.slow_since > touch.tick) {  // wasn't slow before
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
  RestLog& log = log_of(body);
  log.rests = false;
  if (slow_from > now || log.slow_since > now) log.slow_since = slow_from;
  log.due = log.slow_since == k_never ? k_never : std::max(log.slow_since + rest_span(), now);
  if (log.in_place) log.due = std::min(log.due, now + rest_span());
}

void Resting::flies(BodyId body, Tick now) {
  if (!enabled()) return;
  RestLog& log = log_of(body);
  if (log.slow_since <= now) return;
  log.slow_since = k_never;
  log.due = due_if_not_slow(log, now);
}

void Resting::disturbed(BodyId body) {
  if (enabled()) log_of(body).disturb();
}

void Resting::lies(BodyId body, const Vec3& centre_m, std::span<const TouchRecord> touches,
                   std::span<const BodyId> supporters) {
  RestLog& log = log_of(body);
  log.rests = true;
  log.rests_at_m = centre_m;
  log.held_count = static_cast<std::uint32_t>(touches.size());
  std::ranges::copy(touches, log.held.begin());
  log.supporter_count = static_cast<std::uint32_t>(supporters.size());
  std::ranges::copy(supporters, log.supporters.begin());
}

std::span<const BodyId> Resting::supporters(BodyId body) const {
  const RestLog& log = log_of(body);
  return {log.supporters.data(), log.rests ? log.supporter_count : 0};
}

std::span<const BodyId> Resting::wake(BodyId body) {
  woken_.clear();
  for (BodyId other{}; other < logs_.logs.size(); ++other) {
    if (!log_of(other).rests_on(body)) continue;
    log_of(other).rests = false;
    woken_.push_back(other);
  }
  return woken_;
}

void Resting::woke(BodyId body, Tick now, const Pose& pose) {
  RestLog& log = log_of(body);
  log.in_place = true;
  // While others may still rest on the body, keep its first place. Otherwise the place would creep.
  if (!log.has_place) log.place = pose;
  log.has_place = true;
  log.slow_since = now;
  log.due = now + rest_span();
}

bool Resting::has_left(BodyId body, const Pose& pose, double speed_mps) const {
  if (speed_mps >= logs_.rule.rest_speed_mps) return true;
  const double reach_m = logs_.bodies[body].reach_m;
  return moved_m_max(log_of(body).place, pose, reach_m) > k_in_place * reach_m;
}

RestState Resting::state_of(BodyId body, std::vector<TouchRecord>& touches) const {
  if (!enabled()) return {};
  const RestLog& log = log_of(body);
  RestState state = log;
  if (!log.rests) state.held_count = 0;
  state.first_touch = touches.size();
  touches.insert(touches.end(), log.records.begin(), log.records.begin() + log.count);
  touches.insert(touches.end(), log.held.begin(), log.held.begin() + state.held_count);
  return state;
}

void Resting::restore(BodyId body, const RestState& state, std::span<const TouchRecord> touches) {
  if (!enabled()) return;
  RestLog& log = log_of(body);
  static_cast<RestState&>(log) = state;
  const auto first = touches.begin() + static_cast<std::ptrdiff_t>(state.first_touch);
  std::copy_n(first, log.count, log.records.begin());
  std::copy_n(first + log.count, log.held_count, log.held.begin());
}

}  // namespace sleight::physics
