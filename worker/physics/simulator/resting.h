// When do bodies come to rest, what holds them, and what wakes them?
//
// Idea. Slow bodies in contact bounce by micrometres for ever (restitution.h keeps the rate of
// these impacts bounded). A set of bodies goes to rest when each of them
//   - was slower than rest_speed_mps at every collision of the last rest_time_s, and is so now;
//   - is carried, as far as it touched anything in that time, by members of the set, resting bodies
//     and static geometry only: what lies on it may still move (a heap into which grains fall rests
//     from below), unless it needs that for its balance;
//   - is in balance: pushes along the normals of those contacts, with friction, can carry its
//     weight, and could if its centre were a little to any side. A sphere needn't stand so firmly;
//     nor need another body that has been slow for 64 times as long, in which what balances on an
//     edge topples, while a cube that rocks on two opposite corners does not.
// The last one keeps what is slow because it is about to topple or to slide from being frozen.
// Everything is read from recorded contacts, so the decision is a function of the events so far.
//
// A resting body is an obstacle. It remembers those bodies as its supporters: when one of them
// moves, it wakes. It also wakes when a collision, or a user, would give it a speed above
// wake_speed_mps(); below, it takes the blow as static geometry does.
//
// Invariants
//   1. A body rests only by decide(), which is asked at the body's own rest event.
//   2. Nothing is allocated after reset().
// Thread safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/event/event.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/simulator/scene.h"

namespace sleight::physics {

/// A body's partner is static geometry.
inline constexpr std::uint32_t k_static_partner = UINT32_MAX;

/// So many slow collisions without a fast one stand for any rest time: a body that is jammed
/// between others collides without time passing.
inline constexpr std::uint32_t k_slow_collisions = 256;

/// One impact as a body felt it.
struct TouchRecord {
  Tick tick{};
  std::uint32_t partner = k_static_partner;
  double friction = 0;
  Vec3 normal = Vec3::Zero();  ///< from the partner to the body
  Vec3 arm_m = Vec3::Zero();   ///< from the body's centre to the contact
};

/// Whether forces at contacts, each within its friction cone, can hold a weight that acts at a
/// place from the body's centre: sums of forces and of torques are zero to within a small part of
/// the weight. `reach_m` turns torques into forces. Cones are pyramids of four edges, which lie
/// inside of them.
bool can_carry(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
               const Vec3& weight_at_m = Vec3::Zero());

class Resting {
 public:
  /// What the decision needs to know of a body at present.
  struct Present {
    double speed_mps = 0;  ///< of its fastest point, at most
    Vec3 weight_n = Vec3::Zero();
    double reach_m = 0;
    bool round = false;       ///< a sphere: it may stand where others would topple
    bool in_balance = false;  ///< it stays in contact without acceleration
  };

  void reset(std::size_t bodies, const SlowContacts& rule);

  bool enabled() const { return rule_.rest_speed_mps > 0; }
  double wake_speed_mps() const;

  /// A collision of a body: its fastest point's speed before and after, and how fast the contact
  /// parts. One that parts faster than slow bounces do is not slow: the body would freeze in the
  /// air.
  void touched(std::uint32_t body, const TouchRecord& record, double before_mps, double after_mps,
               double parting_mps);
  /// A body begins a segment in which it stays in contact; it is slow from a tick of that on, or
  /// not (k_never).
  void stays(std::uint32_t body, Tick now, Tick slow_from);
  /// It leaves that contact without a blow.
  void flies(std::uint32_t body, Tick now);
  /// A contact that lasts, for the decision that is about to be made.
  void still_touches(std::uint32_t body, const TouchRecord& touch) { record(logs_[body], touch); }
  /// The body's motion changed for another reason.
  void disturbed(std::uint32_t body);

  /// When the body asks next whether it may rest; k_never if it isn't slow.
  Tick due(std::uint32_t body) const { return logs_[body].due; }

  /// Asks for a body. The set that goes to rest, in ascending order; empty if it doesn't yet, and
  /// then it asks again later. present(body) gives a body's present state.
  template <class PresentOf>
  std::span<const std::uint32_t> decide(std::uint32_t body, Tick now, const PresentOf& present);

  /// The bodies that rest on a body, in ascending order, all the way up; they are no longer
  /// resting.
  std::span<const std::uint32_t> wake(std::uint32_t body);

 private:
  static constexpr std::size_t k_records = 16;

  struct Log {
    Tick slow_since = k_never;
    Tick counted_since{};  ///< slow_collisions are counted from here
    Tick due = k_never;
    std::uint32_t slow_collisions = 0;
    std::uint32_t count = 0;  ///< of records
    std::array<TouchRecord, k_records> records;
    std::uint32_t supporter_count = 0;
    std::array<std::uint32_t, k_records> supporters{};  ///< of a resting body
    bool rests = false;

    bool leans_on(std::uint32_t other) const {
      const auto end = supporters.begin() + supporter_count;
      return std::find(supporters.begin(), end, other) != end;
    }
  };

  /// Whether contacts carry a body that has been slow for so long: firmly, with its weight a little
  /// to any side, or as it is, and then for long enough to have toppled otherwise.
  bool stands(std::span<const TouchRecord> contacts, const Present& state, TickCount slow) const;
  enum class Contacts : std::uint8_t { pushing_up, all };
  /// Whether a body may rest together with what carries it, by these of everybody's contacts; set_
  /// is then that set, and rests.
  template <Contacts k_which, class PresentOf>
  bool gather(std::uint32_t body, Tick now, const PresentOf& present);
  /// Valid until the next call.
  template <Contacts k_which>
  std::span<const TouchRecord> chosen(std::span<const TouchRecord> contacts, const Present& state) {
    return k_which == Contacts::all ? contacts : pushing_up(contacts, state);
  }
  std::span<const TouchRecord> pushing_up(std::span<const TouchRecord> contacts,
                                          const Present& state);
  /// Records of the last rest_time_s, moved to the front of the list.
  std::span<const TouchRecord> recent(Log& log, Tick now) const;
  void record(Log& log, const TouchRecord& touch) const;
  TickCount rest_span() const { return ticks_after(rule_.rest_time_s); }

  SlowContacts rule_;
  std::vector<Log> logs_;
  std::vector<std::uint32_t> set_;                 ///< scratch
  std::array<TouchRecord, k_records> pushing_up_;  ///< scratch
};

template <Resting::Contacts k_which, class PresentOf>
bool Resting::gather(std::uint32_t body, Tick now, const PresentOf& present) {
  const auto is_jammed = [](const Log& log) { return log.slow_collisions >= k_slow_collisions; };
  // The bodies that carry it, and those that carry these, as long as all are slow. Whether they
  // stand costs most, so it is asked last.
  set_.assign(1, body);
  for (std::size_t i = 0; i < set_.size(); ++i) {
    Log& log = logs_[set_[i]];
    const Present state = present(set_[i]);
    const auto contacts = recent(log, now);
    const bool slow = log.slow_since != k_never &&
                      (now - log.slow_since >= rest_span() || is_jammed(log)) &&
                      state.speed_mps < rule_.rest_speed_mps;
    if (!slow || contacts.empty()) return false;
    for (const TouchRecord& touch : chosen<k_which>(contacts, state)) {
      if (touch.partner == k_static_partner || logs_[touch.partner].rests) continue;
      if (std::find(set_.begin(), set_.end(), touch.partner) == set_.end())
        set_.push_back(touch.partner);
    }
  }
  for (const std::uint32_t member : set_) {
    Log& log = logs_[member];
    const Present state = present(member);
    const auto contacts = chosen<k_which>(recent(log, now), state);
    if (is_jammed(log) || state.in_balance) continue;
    if (!stands(contacts, state, now - log.slow_since)) return false;
  }
  // They rest, each on the bodies that carry it.
  std::sort(set_.begin(), set_.end());
  for (const std::uint32_t member : set_) {
    Log& log = logs_[member];
    log.supporter_count = 0;
    for (const TouchRecord& touch : chosen<k_which>(recent(log, now), present(member))) {
      if (touch.partner == k_static_partner || log.leans_on(touch.partner)) continue;
      log.supporters[log.supporter_count++] = touch.partner;
    }
    log.rests = true;
    log.slow_since = k_never;
    log.due = k_never;
    log.slow_collisions = 0;
    log.count = 0;
  }
  return true;
}

template <class PresentOf>
std::span<const std::uint32_t> Resting::decide(std::uint32_t body, Tick now,
                                               const PresentOf& present) {
  const bool may =
      gather<Contacts::pushing_up>(body, now, present) || gather<Contacts::all>(body, now, present);
  if (!may) {
    Log& log = logs_[body];
    log.due = now + std::max<TickCount>(1, rest_span() / 2);
    log.slow_collisions = 0;
    if (present(body).speed_mps >= rule_.rest_speed_mps) disturbed(body);
    return {};
  }

  return set_;
}

}  // namespace sleight::physics
