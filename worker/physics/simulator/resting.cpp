#include "worker/physics/simulator/resting.h"

#include <algorithm>
#include <cmath>

#include "common/math/vector.h"

namespace sleight::physics {
namespace {

/// A body wakes from a blow that would give it this many times the speed below which it rests: more
/// than slow neighbours can.
constexpr double k_wake_over_rest = 4;
/// Balance may miss by this part of the weight.
constexpr double k_balance_tolerance = 0.002;
/// A body stands firmly if it would with its centre so far to any side, as a part of its reach: a
/// cube that stands on an edge does not.
constexpr double k_firm = 0.01;
/// Sweeps over all pushes in the search for balance.
constexpr int k_balance_sweeps_max = 400;
/// Contacts of one partner closer together than this part of the arm count as one.
constexpr double k_same_place = 0.05;

/// A push: force, and torque over the reach.
struct Wrench {
  Vec3 force;
  Vec3 torque;
};

double product(const Wrench& a, const Wrench& b) {
  return math::dot(a.force, b.force) + math::dot(a.torque, b.torque);
}

Vec3 any_tangent(const Vec3& normal) {
  const Vec3 axis = std::fabs(normal.x()) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  return math::normalized(math::cross(normal, axis));
}

}  // namespace

bool can_carry(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
               const Vec3& weight_at_m) {
  // The edges of the friction pyramids.
  constexpr std::size_t k_edges = 4;
  constexpr std::size_t k_contacts_max = 16;
  std::array<Wrench, k_edges * k_contacts_max> pushes;
  std::array<double, k_edges * k_contacts_max> share{};
  std::size_t count = 0;
  for (const TouchRecord& touch : contacts.first(std::min(contacts.size(), k_contacts_max))) {
    const Vec3 first = any_tangent(touch.normal);
    const Vec3 second = math::cross(touch.normal, first);
    for (const Vec3& tangent : {first, Vec3(-first), second, Vec3(-second)}) {
      const Vec3 force = touch.normal + touch.friction * tangent;
      pushes[count++] = {force, math::cross(touch.arm_m, force) / reach_m};
    }
  }
  // Non-negative least squares by coordinate descent.
  const double weight = math::norm(weight_n);
  if (weight == 0) return true;
  Wrench rest{weight_n / weight, math::cross(weight_at_m, weight_n) / (weight * reach_m)};
  for (int sweep = 0; sweep < k_balance_sweeps_max; ++sweep) {
    if (product(rest, rest) < k_balance_tolerance * k_balance_tolerance) return true;
    for (std::size_t i = 0; i < count; ++i) {
      const double better =
          std::max(0.0, share[i] - product(rest, pushes[i]) / product(pushes[i], pushes[i]));
      const double change = better - share[i];
      share[i] = better;
      rest.force += change * pushes[i].force;
      rest.torque += change * pushes[i].torque;
    }
  }
  return false;
}

bool Resting::carries(std::span<const TouchRecord> contacts, const Present& state) {
  const double weight = math::norm(state.weight_n);
  if (state.round || weight == 0) return can_carry(contacts, state.weight_n, state.reach_m);
  // What carries the weight at the corners of a square carries it inside as well.
  const Vec3 first = any_tangent(state.weight_n / weight);
  const Vec3 second = math::cross(state.weight_n / weight, first);
  for (const Vec3& side : {first, second, Vec3(-first), Vec3(-second)}) {
    const Vec3 at_m = k_firm * state.reach_m * side;
    if (!can_carry(contacts, state.weight_n, state.reach_m, at_m)) return false;
  }
  return true;
}

void Resting::reset(std::size_t bodies, const SlowContacts& rule) {
  rule_ = rule;
  logs_.assign(enabled() ? bodies : 0, {});
  set_.reserve(bodies);
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
  if (place == k_records) {
    place = 0;
    for (std::size_t i = 1; i < k_records; ++i) {
      if (log.records[i].tick < log.records[place].tick) place = i;
    }
  } else if (place == log.count) {
    ++log.count;
  }
  log.records[place] = touch;
}

void Resting::touched(std::uint32_t body, const TouchRecord& touch, double before_mps,
                      double after_mps) {
  if (!enabled()) return;
  Log& log = logs_[body];
  log.rests = false;
  record(log, touch);
  if (before_mps >= rule_.rest_speed_mps || after_mps >= rule_.rest_speed_mps) {
    log.slow_since = k_never;
    log.due = k_never;
    log.slow_collisions = 0;
    return;
  }
  if (log.slow_since > touch.tick) {  // not slow yet
    log.slow_since = touch.tick;
    log.due = touch.tick + rest_span();
  }
  if (log.slow_collisions == 0 || touch.tick - log.counted_since > rest_span()) {
    log.slow_collisions = 0;
    log.counted_since = touch.tick;
  }
  if (++log.slow_collisions == k_slow_collisions) log.due = touch.tick;
}

void Resting::stays(std::uint32_t body, Tick now, Tick slow_from) {
  if (!enabled()) return;
  Log& log = logs_[body];
  log.rests = false;
  if (slow_from > now || log.slow_since > now) log.slow_since = slow_from;
  log.due = log.slow_since == k_never ? k_never : std::max(log.slow_since + rest_span(), now);
}

void Resting::flies(std::uint32_t body, Tick now) {
  if (!enabled()) return;
  Log& log = logs_[body];
  if (log.slow_since <= now) return;
  log.slow_since = k_never;
  log.due = k_never;
}

void Resting::disturbed(std::uint32_t body) {
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

std::span<const std::uint32_t> Resting::wake(std::uint32_t body) {
  set_.clear();
  if (!enabled()) return set_;
  const auto gather = [&](std::uint32_t moved) {
    for (std::uint32_t other = 0; other < logs_.size(); ++other) {
      Log& log = logs_[other];
      if (!log.rests ||
          std::find(log.supporters.begin(), log.supporters.end(), moved) == log.supporters.end()) {
        continue;
      }
      log.rests = false;
      set_.push_back(other);
    }
  };
  gather(body);
  for (std::size_t i = 0; i < set_.size(); ++i)
    gather(set_[i]);
  std::sort(set_.begin(), set_.end());
  return set_;
}

}  // namespace sleight::physics
