// The history of one marble, from which a simulation of nearly the same scene replays it
// (marbles.h, "What stays the same").
//
// Ids are those of the simulation that kept the history, and must mean the same balls in the other
// one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/contact/contact_state.h"
#include "worker/physics/contact/recent_contacts.h"
#include "worker/physics/contact/rest_log.h"
#include "worker/physics/event/event.h"
#include "worker/physics/marbles/touch_box.h"
#include "worker/physics/motion/segment.h"

namespace sleight::physics {

/// A ball of Marbles at present.
struct Marble {
  static constexpr FeatureId k_none{UINT32_MAX};
  Segment segment;
  Supports supports;  ///< what it stays on, in contact
  enum class Stance : std::uint8_t { unknown, stands, moves };
  Stance stance = Stance::unknown;  ///< on its supports, where it was when it was last asked for
  Tick stance_tick{};
  // What it does next.
  Tick static_tick = k_never;
  FeatureId static_feature = k_none;
  FeatureId last_feature = k_none;  ///< that it collided with
  Tick pair_tick = k_never;
  CollisionCount collided;
  bool started = false;
  bool suspended = false;
  bool resumes = false;
};

struct MarbleHistory {
  /// A part of its way: the ball is in the box from here to where the next part begins.
  struct Part {
    Tick begin;
    FeatureId last_feature = Marble::k_none;  ///< of static geometry that it collided with
    MotionMode mode = MotionMode::free;
    bool is_alone = false;  ///< left alone in its confinement, which the box is
    TouchBox box;
  };
  /// How it moves there; of one that is left alone, how it did when it was.
  struct Flight {
    Tick begin;
    Vec3 position_m = Vec3::Zero();
    Vec3 velocity_mps = Vec3::Zero();
    Vec3 acceleration_mps2 = Vec3::Zero();
    Vec3 angular_velocity_radps = Vec3::Zero();  ///< as it begins
    FreeFlight flight() const {
      return {.begin = begin,
              .position_m = position_m,
              .velocity_mps = velocity_mps,
              .acceleration_mps2 = acceleration_mps2};
    }
  };
  /// All that goes on from an event.
  struct Checkpoint {
    Tick tick;
    std::size_t parts = 0;     ///< that began up to here
    std::size_t meetings = 0;  ///< the same
    std::uint64_t work = 0;    ///< of events up to here that count as its own
    Marble marble;
    RestState rest;
    std::size_t first_met = 0;  ///< in `met`
    std::size_t met_count = 0;
  };
  /// An event at which another ball had a say.
  struct Meeting {
    Tick tick;
    BodyId partner{};
  };

  std::vector<Part> parts{};
  std::vector<Flight> flights{};  ///< by part
  std::vector<Checkpoint>
      checkpoints{};                ///< its start, after meetings, after some events without one
  std::vector<Meeting> meetings{};  ///< in the order of time
  Checkpoint last{};                ///< after its last event
  // What checkpoints know of contacts.
  std::vector<TouchRecord> touches{};
  std::vector<RecentContacts::Entry> met{};
  std::uint64_t work = 0;  ///< of the events that count as its own
  Tick until{};            ///< known so far
  bool stays = false;      ///< and for good: at rest or left alone, until it is met

  void clear() {
    parts.clear();
    flights.clear();
    checkpoints.clear();
    meetings.clear();
    touches.clear();
    met.clear();
    work = 0;
    stays = false;
  }
  /// Whether it was left alone at a tick.
  bool is_alone_at(Tick tick) const;
  /// The last checkpoint before a tick: null if there is none, or if meetings lie in between of
  /// which nothing more is known; then `is_gap`.
  const Checkpoint* checkpoint_before(Tick tick, bool& is_gap) const;
  std::size_t bytes() const {
    return sizeof(*this) + parts.capacity() * sizeof(Part) + flights.capacity() * sizeof(Flight) +
           checkpoints.capacity() * sizeof(Checkpoint) + meetings.capacity() * sizeof(Meeting) +
           touches.capacity() * sizeof(TouchRecord) +
           met.capacity() * sizeof(RecentContacts::Entry);
  }
};

}  // namespace sleight::physics
