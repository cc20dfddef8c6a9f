// Decides which bodies go to rest together.
//
// Idea. Consider bodies that touch each other. The largest set of them in which each member is slow
// and in balance goes to rest. A slow member was slower than rest_speed_mps at every collision of
// the last rest_time_s, and still is. A balanced member is carried by its recent touches with
// static geometry, resting bodies and members of the set: normal forces with friction at these
// contacts can carry its weight, even if its centre moves a little to any side. Other bodies that a
// member touches may still move, so a heap into which grains fall comes to rest from below.
//
// For spheres, balance with a moved centre is not required. The same holds for bodies that have
// been slow for 64 rest times: by then a body balancing on an edge has toppled, but a cube rocking
// on two opposite corners has not. A body that has been slow for 64 rest times without leaving its
// place counts as standing on all contacts that push it up, even if they don't balance it. For
// example, a ball on a ledge that leans on another ball may lack a thousandth of its weight, yet
// bounce by micrometres for ever.
//
// The balance test keeps slow bodies that are about to topple or slide from being frozen. The test
// includes loads. One system of contact forces (force_balance.h) must hold the set and all resting
// bodies that are connected with it by leaning, in structures of up to k_held_together_max bodies.
// If the forces can't hold the set, the set goes to rest without its least balanced members. A
// resting body that can't bear the set wakes. In larger structures, and for a body that has been
// slow for 64 rest times, each body is tested alone.
//
// A decision requests the state of one body after another from the caller, and then returns an
// outcome:
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
  /// Borrows the logs until decide() returns. REQUIRES: the event is the body's rest event.
  void begin(RestLogs& logs, BodyId body, Tick now);
  /// Returns the next body whose state is needed; if none, call decide(). REQUIRES: the caller has
  /// recorded the lasting contacts of the body (Resting::still_touches) before it calls tell().
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
  /// Whether the body once failed to bear another body that it touches now and that isn't going to
  /// rest.
  bool lacks_load(const RestLog& log) const;
  /// Whether the body has been slow for so long that it must be held somehow: an unheld body would
  /// be fast by now.
  bool has_been_slow(const RestLog& log) const;
  /// Whether a candidate has been near its place for so long that it must be standing.
  bool has_stayed(const RestLog& log) const;
  void note_stay(RestLog& log, const Note& note, double reach_m) const;
  /// Whether the body rests regardless of its balance with others.
  bool holds_anyhow(const RestLog& log) const;
  /// Returns the touches that a body leans on; an empty set if they don't carry the body.
  Contacts supporting(BodyId body) const;
  /// Finds and stores the touches that carry a candidate. Returns whether there are any.
  bool check(BodyId member);

  // Tests of the whole set.
  bool find_set();
  /// Removes from set_ the members that are no longer candidates or that lean on non-candidates.
  /// Returns whether the body itself is still a candidate.
  bool settle_set();
  /// Whether one system of forces holds set_ and all resting bodies connected with it. If forces
  /// don't hold them, either overloaded_ lists some of these bodies, or the least balanced members
  /// stop being candidates.
  bool is_held();
  /// Fills structure_ with set_ and the connected resting bodies. Returns whether structure_ is
  /// small enough.
  bool find_structure();
  /// Whether forces hold the first `count` bodies of structure_; the other bodies count as fixed.
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
