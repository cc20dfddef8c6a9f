// Which bodies go to rest together?
//
// Idea. Among bodies in touch with each other, the largest set goes to rest in which each member
//   - was slower than rest_speed_mps at every collision of the last rest_time_s, and is so now;
//   - is in balance on what it touched in that time, as far as that is static geometry, at rest or
//     in the set: pushes along the normals of those contacts, with friction, can carry its weight,
//     and could if its centre were a little to any side. Other bodies that it touches may still
//     move (a heap into which grains fall rests from below). A sphere needn't stand so firmly; nor
//     need another body that has been slow for 64 times as long, in which what balances on an edge
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
//
// A decision asks the caller how bodies are at present, one after another, and then has an outcome:
//
//   decision.begin(logs, body, now);
//   while (const auto asked = decision.asks()) decision.tell(*asked, present state of *asked);
//   carry out decision.decide();
//
// Invariants
//   1. The outcome is a function of the logs and of what was told.
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
  /// How a body is at present.
  struct Present {
    double speed_mps = 0;  ///< of its fastest point, at most
    Vec3 centre_m = Vec3::Zero();
    bool stays = false;   ///< in contact with static geometry, on these features
    bool stands = false;  ///< and would not accelerate there if it stood still
    std::span<const StaticId> stays_on;
  };
  struct Outcome {
    std::span<const BodyId> rest;  ///< these go to rest, ascending; if none, the body asks later
    std::span<const BodyId> wake;  ///< these can't bear what was to rest on them
    std::span<const BodyId> read;  ///< of these resting bodies the place made a difference
  };

  void reset(std::size_t bodies);
  /// Borrows the logs until the outcome. REQUIRES: it is the body's rest event.
  void begin(RestLogs& logs, BodyId body, Tick now);
  /// The next body to tell about; none: decide. Contacts that last are recorded before that
  /// (Resting::still_touches).
  std::optional<BodyId> asks();
  void tell(BodyId body, const Present& present);
  /// Writes what follows to the logs. Valid until the next one begins.
  Outcome decide();

 private:
  /// What a decision notes about a body on its way.
  struct Note {
    std::uint64_t round = 0;  ///< the last decision that it was asked about in
    bool candidate = false;   ///< it may rest, as far as is known
    bool unheld = false;      ///< but for the balance of all
    bool holds = false;       ///< it stays in contact, and would not accelerate if it stood still
    bool slides = false;      ///< it touches only what it stays on, and would accelerate
    Contacts carried = 0;     ///< by these of its touches
    double speed_mps = 0;
    Vec3 centre_m = Vec3::Zero();
    std::uint64_t in_structure = 0;     ///< the last one that it was in
    std::uint32_t structure_place = 0;  ///< in that; k_fixed if it counts as fixed
  };

  RestLog& log_of(BodyId body) const { return logs_->logs[body]; }

  // One body.
  bool may_lean_on(const TouchRecord& touch) const;
  /// Whether it must bear what doesn't rest with it.
  bool lacks_load(const RestLog& log) const;
  /// Whether it has been slow for so long, wherever that has brought it: what others don't hold
  /// would be fast by then.
  bool has_been_slow(const RestLog& log) const;
  /// Whether a candidate has been about its place for so long that it must be standing.
  bool has_stayed(const RestLog& log) const;
  void note_stay(RestLog& log, const Note& note, double reach_m) const;
  /// Whether its balance with others doesn't matter.
  bool holds_anyhow(const RestLog& log) const;
  /// Of its touches, those that it leans on; none if it isn't carried.
  Contacts supporting(BodyId body) const;
  /// Notes what carries a candidate; whether anything does.
  bool check(BodyId member);

  // The set.
  bool find_set();
  /// Takes those out of set_ that are no longer candidates, or lean on such. Whether the body is
  /// still one.
  bool settle_set();
  /// Whether one system of forces holds set_, and all resting bodies that hang together with it. If
  /// not, either some of these are overloaded_, or the members that miss most are no candidates any
  /// more.
  bool is_held();
  /// Finds structure_: set_ and those resting bodies. Whether it is small enough.
  bool find_structure();
  /// Whether forces hold the first so many of structure_; the others count as fixed.
  bool balances(std::size_t count);
  void lay_down_set();
  void ask_later();

  RestLogs* logs_ = nullptr;
  BodyId body_{};
  Tick now_{};
  std::size_t asked_of_ = 0;  ///< the member of set_ whose partners are asked about
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
  std::uint64_t structures_ = 0;  ///< found so far
};

}  // namespace sleight::physics
