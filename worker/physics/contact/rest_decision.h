// Decides which bodies go to rest together.
//
// Idea. Consider bodies that touch each other, and sets of them in which each member is slow and in
// balance. The largest of these sets goes to rest. A member is slow if it was slower than
// rest_speed_mps at every collision of the last rest_time_s, and still is. Consider the member's
// recent touches with static geometry, resting bodies and members of the set. The member is in
// balance if normal forces and friction at these touches can carry its weight, even if its centre
// moves a little to any side. Members may also touch bodies that still move. So a heap into which
// grains fall comes to rest from below.
//
// For spheres, balance with a moved centre is not required. Bodies that have been slow for 64 rest
// times need no such balance either: by then a body balancing on an edge has toppled, but a cube
// rocking on two opposite corners has not. If a body has been slow for 64 rest times without
// leaving its place, it counts as standing on all contacts that push it up, even without balance.
// For example, if a ball on a ledge leans on another ball, its contacts may fail to carry a
// thousandth of its weight, but the ball bounces by micrometres for ever.
//
// The balance test prevents a slow body from being frozen when it is about to topple or slide. The
// test includes loads. A structure is the set and all resting bodies connected with it by leaning.
// In structures of up to k_held_together_max bodies, one system of contact forces (force_balance.h)
// must hold all bodies. If the forces can't hold the set, the set goes to rest without its least
// balanced members. If a resting body can't bear the set, it wakes. Each body is tested alone in
// larger structures, and after it has been slow for 64 rest times.
//
// A decision asks the caller for the state of one body after another, and then returns an outcome:
//
//   decision.begin(logs, body, now);
//   while (const auto asked = decision.asks()) decision.tell(*asked, present state of *asked);
//   carry out decision.decide();
//
// Invariants
//   1. The outcome depends only on the logs and the states passed to tell().
//   2. Nothing is allocated after reset().
// Thread safety: none.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "worker/physics/contact/force_balance.h"
#include "worker/physics/contact/rest_log.h"
#include "worker/physics/contact/weight_balance.h"

namespace sleight::physics {

class RestDecision {
 public:
  struct Present {
    double speed_mps = 0;  ///< upper bound for its fastest point
    Vec3 centre_m = Vec3::Zero();
    bool stays = false;   ///< in contact with the static features stays_on
    bool stands = false;  ///< if so, would not accelerate if it stood still
    std::span<const StaticId> stays_on;
  };
  struct Outcome {
    std::span<const BodyId>
        rest;  ///< bodies that go to rest, ascending; if empty, the body retries later
    std::span<const BodyId> wake;  ///< resting bodies that can't bear the candidates
    std::span<const BodyId> read;  ///< resting bodies whose places affected the outcome
  };

  void reset(std::size_t bodies);
  /// Borrows the logs until decide() returns. REQUIRES: it is the time of the body's rest event.
  void begin(RestLogs& logs, BodyId body, Tick now);
  /// Returns the next body whose state is needed. If there is none, call decide(). REQUIRES: before
  /// calling tell(), the caller records the body's lasting contacts (Resting::still_touches).
  std::optional<BodyId> asks();
  void tell(BodyId body, const Present& present);
  /// Updates the logs. The outcome is valid until the next begin().
  Outcome decide();

 private:
  /// A body's intermediate results in a decision.
  struct Note {
    std::uint64_t round = 0;  ///< last decision that involved the body
    bool candidate = false;   ///< may rest, as far as known
    bool unheld = false;      ///< would be a candidate if forces could hold all
    bool holds = false;       ///< stays in contact, and would not accelerate if it stood still
    bool slides = false;      ///< touches only what it stays on, and would accelerate
    Contacts carried = 0;     ///< the touches that carry the body
    double speed_mps = 0;
    Vec3 centre_m = Vec3::Zero();
    std::uint64_t in_structure = 0;     ///< last structure that contained the body
    std::uint32_t structure_place = 0;  ///< index there; k_fixed: counts as fixed
  };

  RestLog& log_of(BodyId body) const { return logs_->logs[body]; }

  // Tests of one body.
  bool may_lean_on(const TouchRecord& touch) const;
  /// Whether the body once failed to bear another body, still touches it, and can't lean on it.
  bool lacks_load(const RestLog& log) const;
  /// Whether the body has been slow for so long that something must hold it. An unheld body would
  /// be fast by now.
  bool has_been_slow(const RestLog& log) const;
  /// Whether a candidate has been near its place for so long that it must be standing.
  bool has_stayed(const RestLog& log) const;
  void note_stay(RestLog& log, const Note& note, double reach_m) const;
  /// Whether the body rests even if it isn't in balance with others.
  bool holds_anyhow(const RestLog& log) const;
  /// Returns the touches that a body leans on. If no touches carry the body, returns an empty set.
  Contacts supporting(BodyId body) const;
  /// Finds and stores the touches that carry a candidate. Returns whether there are any.
  bool check(BodyId member);

  // Tests of the whole set.
  bool find_set();
  /// Removes from set_ each member that is no longer a candidate or leans on a body that isn't one.
  /// Returns whether the body itself is still a candidate.
  bool settle_set();
  /// Returns whether one system of forces holds set_ and all resting bodies connected with it. If
  /// not, either overloaded_ lists resting bodies that can't bear the set, or the least balanced
  /// members stop being candidates.
  bool is_held();
  /// Fills structure_ with set_ and the connected resting bodies. Returns whether structure_ is
  /// small enough.
  bool find_structure();
  /// Returns whether forces hold the first `count` bodies of structure_. The other bodies count as
  /// fixed.
  bool balances(std::size_t count);
  void lay_down_set();
  void ask_later();

  RestLogs* logs_ = nullptr;
  BodyId body_{};
  Tick now_{};
  std::size_t asked_of_ = 0;  ///< member of set_ whose partners come next
  std::size_t touch_ = 0;     ///< and the next of its touches
  std::vector<Note> notes_;   ///< by body
  std::vector<BodyId> set_;
  std::vector<BodyId> structure_;
  std::vector<BodyId> overloaded_;
  std::vector<BodyId> read_;
  std::vector<HeldBody> held_bodies_;
  std::vector<HoldingContact> holding_;
  ForceBalance balance_;
  std::uint64_t round_ = 0;       ///< decisions so far
  std::uint64_t structures_ = 0;  ///< structures so far
};

}  // namespace sleight::physics
