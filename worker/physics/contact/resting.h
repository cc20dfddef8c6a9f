// When do bodies come to rest, what holds them, and what wakes them?
//
// Idea. Slow bodies in contact bounce by micrometres for ever (restitution.h keeps the rate of
// these impacts bounded). Of the bodies in touch with each other, the greatest set goes to rest of
// which each member
//   - was slower than rest_speed_mps at every collision of the last rest_time_s, and is so now;
//   - is in balance on what it touched in that time, as far as that is static geometry, at rest or
//     in the set: pushes along the normals of those contacts, with friction, can carry its weight,
//     and could if its centre were a little to any side. What else it touches may still move (a
//     heap into which grains fall rests from below). A sphere needn't stand so firmly; nor need
//     another body that has been slow for 64 times as long, in which what balances on an edge
//     topples, while a cube that rocks on two opposite corners does not. A body that has been slow
//     for so long without leaving its place stands on all contacts that push it up, whether or not
//     they balance it: a ball on a ledge that leans on another one may lack a thousandth of its
//     weight, and yet only bounce by micrometres for ever.
// Balance keeps a body that is slow because it is about to topple or to slide from being frozen.
// What lies on a body counts as well: the set, with all resting bodies that it leans on, that lean
// on these, and so on, is held by one system of contact forces (force_balance.h), in structures of
// up to k_held_together_max bodies. A set that is not goes to rest without the members that miss
// most; resting bodies that can't bear it wake. In greater structures, and for a body that has been
// slow for 64 rest times, each body is looked at by itself.
//    Everything is read from recorded contacts, so the decision is a function of the events so far.
//
// A resting body is an obstacle. The bodies that pushed in its balance are its supporters. It wakes
// when a collision, or a user, would give it a speed above wake_speed_mps(); below, it takes the
// blow as static geometry does. It also wakes when a supporter moves. A supporter moves if it wakes
// from a blow, or if its own supporter moved and it then is fast or leaves its place. So a blow
// does not wake a whole heap: a body that may have lost its support is looked at, and the bodies on
// it sleep on unless it leaves its place.
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

#include "worker/physics/contact/force_balance.h"
#include "worker/physics/contact/touch_record.h"
#include "worker/physics/contact/weight_balance.h"
#include "worker/physics/event/event.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/scene/scene.h"

namespace sleight::physics {

class Resting {
 public:
  /// What is known of a body's balance without a look at its contacts.
  enum class Stance : std::uint8_t {
    unknown,
    holds,  ///< it stays in contact, and would not accelerate if it stood still
    slides  ///< it touches only what it stays on, and would accelerate
  };
  /// What the decision needs to know of a body at present.
  struct Present {
    double speed_mps = 0;  ///< of its fastest point, at most
    Vec3 weight_n = Vec3::Zero();
    double reach_m = 0;
    Vec3 centre_m = Vec3::Zero();
    bool round = false;  ///< a sphere: it may stand where others would topple
    Stance stance = Stance::unknown;
  };

  /// So many slow collisions as make a body jammed must come within a span.
  void reset(std::size_t bodies, const SlowContacts& rule, TickCount jam_span);

  struct Touches {
    std::array<TouchRecord, k_touch_records_max> records;
    std::size_t count = 0;
  };
  /// What a body touched in the last rest_time_s.
  Touches touches(BodyId body, Tick now) {
    const auto felt = recent(logs_[body], now);
    Touches copy;
    copy.count = felt.size();
    std::copy(felt.begin(), felt.end(), copy.records.begin());
    return copy;
  }

  bool enabled() const { return rule_.rest_speed_mps > 0; }
  /// How long what a body touched counts.
  TickCount rest_span() const { return ticks_after(rule_.rest_time_s); }
  double wake_speed_mps() const;

  /// Whether a collision of a body is a slow one, by its fastest point's speed before and after,
  /// and by how fast the contact parts. One that parts faster than slow bounces do is not slow: the
  /// body would freeze in the air.
  bool is_slow(double before_mps, double after_mps, double parting_mps) const;
  /// A collision of a body.
  void touched(BodyId body, const TouchRecord& record, bool slowly);
  /// A body begins a segment in which it stays in contact; it is slow from a tick of that on, or
  /// not (k_never).
  void stays(BodyId body, Tick now, Tick slow_from);
  /// It leaves that contact without a blow.
  void flies(BodyId body, Tick now);
  /// A contact that lasts, for the decision that is about to be made.
  void still_touches(BodyId body, const TouchRecord& touch) { record(logs_[body], touch); }
  /// The body's motion changed for another reason.
  void disturbed(BodyId body);

  /// Whether a body touched nothing in the last rest_time_s but these features of static geometry.
  bool touched_only(BodyId body, Tick now, std::span<const StaticId> features) {
    return std::ranges::all_of(recent(logs_[body], now), [&](const TouchRecord& touch) {
      return touch.partner == k_static_partner &&
             std::ranges::find(features, touch.feature) != features.end();
    });
  }

  /// Calls visit(partner) for each other body that a body touched in the last rest_time_s, more
  /// than once perhaps: its own rest depends on theirs.
  template <class Visit>
  void for_each_partner(BodyId body, Tick now, const Visit& visit) const {
    for (const TouchRecord& touch : logs_[body].touches()) {
      if (touch.partner != k_static_partner && now - touch.tick <= rest_span())
        visit(touch.partner);
    }
  }

  /// Calls visit(supporter) for each body that a resting one leans on.
  template <class Visit>
  void for_each_supporter(BodyId body, const Visit& visit) const {
    const Log& log = logs_[body];
    for (std::uint32_t i = 0; log.rests && i < log.supporter_count; ++i)
      visit(log.supporters[i]);
  }

  /// When the body asks next whether it may rest; k_never if it isn't slow.
  Tick due(BodyId body) const { return logs_[body].due; }

  /// Asks for a body. The set that goes to rest, in ascending order; empty if it doesn't yet, and
  /// then it asks again later. present(body) gives a body's present state, and looks(body) what of
  /// that doesn't change while it rests, of one at rest.
  template <class PresentOf, class LooksOf>
  std::span<const BodyId> decide(BodyId body, Tick now, const PresentOf& present,
                                 const LooksOf& looks);
  /// After it: resting bodies that can't bear what was to rest on them. They are to wake.
  std::span<const BodyId> overloaded() const { return overloaded_; }
  /// One of these no longer rests, and not again before what it couldn't bear rests with it.
  void rouse(BodyId body, BodyId load) {
    logs_[body].rests = false;
    logs_[body].must_bear = load;
  }

  /// The bodies that rest on a body, in ascending order; they are no longer resting. Those that
  /// rest on them still do, until they leave their place.
  std::span<const BodyId> wake(BodyId body);
  /// A body begins at rest, on some others; what may hold it. REQUIRES: at most k_touch_records_max
  /// of either.
  void lies(BodyId body, std::span<const TouchRecord> touches, std::span<const BodyId> supporters);
  /// A body woke without a blow, where it rested.
  void woke(BodyId body, Tick now, const Pose& pose);
  /// Whether others may still rest on a body that woke.
  bool in_place(BodyId body) const { return enabled() && logs_[body].in_place; }
  /// Whether such a body, in another pose and at a speed by now, has left its place.
  bool has_left(BodyId body, const Pose& pose, double speed_mps, double reach_m) const;
  /// It is in no place any more.
  void leave(BodyId body) { logs_[body].in_place = logs_[body].has_place = false; }

  /// All that is known of a body, for a simulation that goes on from here. What it touched lies in
  /// a list that contact_states share, since most touched little.
  class State;
  using TouchList = std::vector<TouchRecord>;
  State state_of(BodyId body, TouchList& touches) const;
  void restore(BodyId body, const State& state, std::span<const TouchRecord> touches);

 private:
  /// Of a body, but for what it touched and for what a decision notes on its way.
  struct Known {
    Tick slow_since = k_never;
    Tick counted_since{};  ///< slow_collisions are counted from here
    Tick due = k_never;
    std::uint32_t slow_collisions = 0;
    std::uint32_t count = 0;  ///< of records
    std::uint32_t supporter_count = 0;
    std::array<BodyId, k_touch_records_max> supporters{};  ///< of a resting body
    std::uint32_t held_count = 0;                          ///< of contacts that may hold it
    bool rests = false;
    bool rests_anyhow = false;            ///< whatever balances it
    BodyId must_bear = k_static_partner;  ///< another body, while that touches it
    bool has_place = false;               ///< some may have rested on it since it was there
    bool in_place = false;                ///< awake, and others may still rest on it
    Pose place{};
    Tick stays_since = k_never;  ///< slow, and about there all the time; as decisions found it
    Vec3 stays_at_m = Vec3::Zero();

    bool leans_on(BodyId other) const {
      const auto end = supporters.begin() + supporter_count;
      return std::find(supporters.begin(), end, other) != end;
    }
  };
  struct Log : Known {
    std::array<TouchRecord, k_touch_records_max> records;
    std::array<TouchRecord, k_touch_records_max> held;  ///< of a resting body
    // Of the last decision in which the body was looked at.
    bool candidate = false;  ///< it may rest, as far as is known
    bool unheld = false;     ///< but for the balance of all
    std::uint32_t carried = 0;
    std::uint64_t round = 0;
    Present state{};
    std::uint64_t in_structure = 0;     ///< the last one that it was in
    std::uint32_t structure_place = 0;  ///< in that; k_fixed if it counts as fixed

    void forget() {
      static_cast<Known&>(*this) = {};
      round = in_structure = 0;
    }
    std::span<const TouchRecord> touches() const { return {records.data(), count}; }
    std::span<const TouchRecord> holding() const { return {held.data(), held_count}; }
  };

  /// Contacts that carry a body that has been slow for so long: firmly, with its weight a little to
  /// any side, or as it is, and then for long enough to have toppled otherwise. None if they don't.
  Contacts carrying(std::span<const TouchRecord> contacts, const Present& state,
                    TickCount slow) const;
  /// The same of those contacts of a body that it may lean on. One that is jammed, or has stayed,
  /// leans on all that push it up.
  Contacts supporting(const Log& log, Tick now) const;
  bool may_lean_on(const TouchRecord& touch) const {
    if (touch.partner == k_static_partner) return true;
    const Log& other = logs_[touch.partner];
    return other.rests || (other.round == round_ && other.candidate);
  }
  static bool is_jammed(const Log& log) { return log.slow_collisions >= k_slow_collisions; }
  /// Whether a candidate has been about its place for so long that it must be standing.
  bool has_stayed(const Log& log, Tick now) const;
  void note_stay(Log& log, Tick now) const;
  /// Whether it has been slow for as long, wherever that has brought it: what others don't hold
  /// would be fast by then.
  bool has_been_slow(const Log& log, Tick now) const;
  /// Finds the greatest set around a body of which each is slow and in balance by what may rest
  /// with it, and leaves it in set_. Whether the body is in it.
  template <class PresentOf, class LooksOf>
  bool gather(BodyId body, Tick now, const PresentOf& present, const LooksOf& looks);
  /// Takes those out of set_ that are no longer candidates, or lean on such. Whether the body is
  /// still one.
  bool settle_set(BodyId body, Tick now);
  /// Whether it must bear what doesn't rest with it.
  bool lacks_load(const Log& log) const {
    return log.must_bear != k_static_partner &&
           std::ranges::any_of(log.touches(), [&](const TouchRecord& touch) {
             return touch.partner == log.must_bear && !may_lean_on(touch);
           });
  }
  /// Notes what carries a candidate; whether anything does.
  bool check(BodyId member, Tick now);
  /// Whether one system of forces holds set_, and all resting bodies that hang together with it. If
  /// not, either some of these are overloaded_, or the members that miss most are no candidates any
  /// more.
  template <class LooksOf>
  bool is_held(Tick now, const LooksOf& looks);
  /// Finds structure_: set_ and those resting bodies. Whether it is small enough.
  template <class LooksOf>
  bool find_structure(const LooksOf& looks);
  /// Whether forces hold the first so many of structure_; the others count as fixed.
  bool balances(std::size_t count, Tick now);
  /// A body of structure_ that balance isn't asked of.
  bool holds_anyhow(const Log& log, Tick now) const {
    return log.rests ? log.rests_anyhow
                     : log.slow_collisions >= k_jams_anyhow * k_slow_collisions ||
                           has_been_slow(log, now);
  }
  /// The bodies of set_ rest, each on the bodies that carry it.
  void lay_down_set(Tick now);
  /// Records of the last rest_time_s, moved to the front of the list.
  std::span<const TouchRecord> recent(Log& log, Tick now) const;
  void record(Log& log, const TouchRecord& touch) const;
  /// A body in its place is looked at again all the same: others may rest on it.
  Tick due_if_not_slow(const Log& log, Tick now) const {
    return log.in_place ? now + rest_span() : k_never;
  }
  SlowContacts rule_;
  TickCount jam_span_ = 0;
  std::vector<Log> logs_;
  std::vector<BodyId> set_;  ///< scratch
  std::vector<BodyId> structure_;
  std::vector<BodyId> overloaded_;
  std::vector<HeldBody> held_bodies_;
  std::vector<HoldingContact> holding_;
  ForceBalance balance_;
  std::uint64_t round_ = 0;       ///< decisions so far
  std::uint64_t structures_ = 0;  ///< found so far
};

class Resting::State {
 public:
  /// Whether the body rested, on that other one among others.
  bool rests_on(BodyId other) const { return known_.rests && known_.leans_on(other); }
  /// Where in the list what it touched lies, and how much that is.
  std::size_t first_touch() const { return first_touch_; }
  std::size_t touch_count() const { return known_.count + known_.held_count; }

 private:
  friend class Resting;
  Known known_;
  std::size_t first_touch_ = 0;  ///< of known_.count in the list, then known_.held_count
};

inline Resting::State Resting::state_of(BodyId body, TouchList& touches) const {
  State state;
  if (!enabled()) return state;
  const Log& log = logs_[body];
  state.known_ = log;
  if (!log.rests) state.known_.held_count = 0;
  state.first_touch_ = touches.size();
  touches.insert(touches.end(), log.records.begin(), log.records.begin() + log.count);
  touches.insert(touches.end(), log.held.begin(), log.held.begin() + state.known_.held_count);
  return state;
}

inline void Resting::restore(BodyId body, const State& state,
                             std::span<const TouchRecord> touches) {
  if (!enabled()) return;
  Log& log = logs_[body];
  log.round = 0;  // what the last decision noted counts no more
  static_cast<Known&>(log) = state.known_;
  const auto first = touches.begin() + static_cast<std::ptrdiff_t>(state.first_touch_);
  std::copy_n(first, log.count, log.records.begin());
  std::copy_n(first + log.count, log.held_count, log.held.begin());
}

template <class PresentOf, class LooksOf>
bool Resting::gather(BodyId body, Tick now, const PresentOf& present, const LooksOf& looks) {
  ++round_;
  set_.clear();
  overloaded_.clear();
  const auto consider = [&](BodyId member) {
    Log& log = logs_[member];
    if (log.round == round_) return;
    log.round = round_;
    log.state = present(member);
    log.unheld = false;
    log.candidate = !recent(log, now).empty() && log.slow_since != k_never &&
                    (now - log.slow_since >= rest_span() || is_jammed(log)) &&
                    log.state.speed_mps < rule_.rest_speed_mps;
    note_stay(log, now);
    if (log.candidate) set_.push_back(member);
  };
  // A body that all candidates together don't carry is carried by no subset of them. The body
  // itself comes first, since mostly that settles it.
  consider(body);
  for (std::size_t i = 0; i < set_.size(); ++i) {
    for (const TouchRecord& touch : logs_[set_[i]].touches()) {
      if (touch.partner != k_static_partner && !logs_[touch.partner].rests) consider(touch.partner);
    }
    check(set_[i], now);
    if (!logs_[body].candidate) return false;
  }
  // Nearly always the first time.
  do {
    if (!settle_set(body, now)) return false;
  } while (!is_held(now, looks) && overloaded_.empty());
  if (!overloaded_.empty()) return false;
  lay_down_set(now);
  return true;
}

inline bool Resting::check(BodyId member, Tick now) {
  Log& log = logs_[member];
  log.carried = lacks_load(log) && !has_been_slow(log, now) ? 0 : supporting(log, now);
  log.candidate = log.carried != 0;
  return log.candidate;
}

inline bool Resting::settle_set(BodyId body, Tick now) {
  // A body that leaned on one that has turned out not to be carried is checked again.
  const auto leans_on_others = [&](const Log& log) {
    const auto contacts = log.touches();
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if ((log.carried >> k & 1U) != 0 && !may_lean_on(contacts[k])) return true;
    }
    return lacks_load(log);
  };
  for (bool again = true; again;) {
    again = false;
    for (const BodyId member : set_) {
      if (logs_[member].candidate && leans_on_others(logs_[member]) && !check(member, now))
        again = true;
    }
    if (!logs_[body].candidate) return false;
  }
  std::erase_if(set_, [&](BodyId member) { return !logs_[member].candidate; });
  std::sort(set_.begin(), set_.end());
  return true;
}

template <class LooksOf>
bool Resting::find_structure(const LooksOf& looks) {
  // A decision may look at several, as its set loses members.
  ++structures_;
  structure_.clear();
  const auto add = [&](BodyId member) {
    Log& log = logs_[member];
    if (log.in_structure == structures_) return;
    log.in_structure = structures_;
    structure_.push_back(member);
  };
  for (const BodyId member : set_)
    add(member);
  for (std::size_t i = 0; i < structure_.size(); ++i) {
    const Log& log = logs_[structure_[i]];
    for (const TouchRecord& touch : log.rests ? log.holding() : log.touches()) {
      if (touch.partner != k_static_partner && logs_[touch.partner].rests) add(touch.partner);
    }
    // Nothing rests on what has been moving.
    const bool bears = log.rests || log.has_place;
    for (BodyId other{}; bears && other < logs_.size(); ++other) {
      if (logs_[other].rests && logs_[other].leans_on(structure_[i])) add(other);
    }
    if (structure_.size() > k_held_together_max) return false;
    if (log.rests) logs_[structure_[i]].state = looks(structure_[i]);
  }
  return true;
}

template <class LooksOf>
bool Resting::is_held(Tick now, const LooksOf& looks) {
  // What leans on static geometry alone is in balance already.
  const bool alone = std::ranges::all_of(set_, [&](BodyId member) {
    const Log& log = logs_[member];
    return !log.has_place && std::ranges::all_of(log.touches(), [&](const TouchRecord& touch) {
      return touch.partner == k_static_partner || !may_lean_on(touch);
    });
  });
  if (alone || !find_structure(looks) || balances(structure_.size(), now)) return true;
  if (structure_.size() > set_.size() && balances(set_.size(), now)) {
    for (const BodyId member : std::span(structure_).subspan(set_.size())) {
      if (std::ranges::any_of(set_, [&](BodyId one) {
            return std::ranges::any_of(logs_[one].touches(), [&](const TouchRecord& touch) {
              return touch.partner == member;
            });
          }))
        overloaded_.push_back(member);
    }
    if (!overloaded_.empty()) return false;
  }
  const auto missing = [&](BodyId member) {
    const std::uint32_t place = logs_[member].structure_place;
    return place == HoldingContact::k_fixed ? 0 : balance_.missing(place);
  };
  double most = 0;
  for (const BodyId member : set_)
    most = std::max(most, missing(member));
  for (const BodyId member : set_) {
    if (missing(member) < k_misses_much * most) continue;
    logs_[member].candidate = false;
    logs_[member].unheld = true;
  }
  return false;
}

inline void Resting::lay_down_set(Tick now) {
  for (const BodyId member : set_) {
    Log& log = logs_[member];
    log.supporter_count = 0;
    log.held_count = 0;
    log.rests_anyhow = holds_anyhow(log, now);
    const auto contacts = log.touches();
    for (const TouchRecord& touch : contacts) {
      if (may_lean_on(touch)) log.held[log.held_count++] = touch;
    }
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const BodyId partner = contacts[k].partner;
      if ((log.carried >> k & 1U) == 0 || partner == k_static_partner || log.leans_on(partner))
        continue;
      log.supporters[log.supporter_count++] = partner;
    }
  }
  for (const BodyId member : set_) {
    Log& log = logs_[member];
    log.rests = true;
    log.must_bear = k_static_partner;
    log.in_place = false;
    log.slow_since = k_never;
    log.due = k_never;
    log.slow_collisions = 0;
    log.count = 0;
  }
}

template <class PresentOf, class LooksOf>
std::span<const BodyId> Resting::decide(BodyId body, Tick now, const PresentOf& present,
                                        const LooksOf& looks) {
  if (!gather(body, now, present, looks)) {
    Log& log = logs_[body];
    // What slides is asked again when it slides otherwise (stays); what leans on others that can't
    // hold it moves with them for a while.
    const bool unheld = log.unheld || !overloaded_.empty();
    const bool later = unheld || log.state.stance == Stance::slides;
    log.due = now + std::max<TickCount>(1, later ? 4 * rest_span() : rest_span() / 2);
    if (is_jammed(log) && !unheld) log.slow_collisions = 0;
    if (log.state.speed_mps >= rule_.rest_speed_mps) disturbed(body);
    return {};
  }

  return set_;
}

}  // namespace sleight::physics
