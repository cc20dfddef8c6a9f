// The history of one marble. A simulation of nearly the same scene can replay it (marbles.h, "What
// stays the same").
//
// A ball id in a history must mean the same ball in the simulation that replays the history.
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

/// The current state of a ball in Marbles.
struct Marble {
  static constexpr FeatureId k_none{UINT32_MAX};
  Segment segment;
  Supports supports;  ///< features it stays on, in contact
  enum class Stance : std::uint8_t { unknown, stands, moves };
  Stance stance = Stance::unknown;  ///< on its supports, when last computed
  Tick stance_tick{};
  // The ball's next event.
  Tick static_tick = k_never;
  FeatureId static_feature = k_none;
  FeatureId last_feature = k_none;  ///< last feature that it collided with
  Tick pair_tick = k_never;
  CollisionCount collided;
  bool started = false;
  bool suspended = false;
  bool resumes = false;
};

struct MarbleHistory {
  /// A part of the ball's path: the ball stays in the box until the next part begins.
  struct Part {
    Tick begin;
    FeatureId last_feature = Marble::k_none;  ///< last static feature that the ball collided with
    MotionMode mode = MotionMode::free;
    bool is_alone = false;  ///< left alone in its confinement, which is the box
    TouchBox box;
  };
  /// Motion in a part. If the ball is left alone in this part, this is the motion at the part's
  /// begin.
  struct Flight {
    Tick begin;
    Vec3 position_m = Vec3::Zero();
    Vec3 velocity_mps = Vec3::Zero();
    Vec3 acceleration_mps2 = Vec3::Zero();
    Vec3 angular_velocity_radps = Vec3::Zero();  ///< at `begin`
    FreeFlight flight() const {
      return {.begin = begin,
              .position_m = position_m,
              .velocity_mps = velocity_mps,
              .acceleration_mps2 = acceleration_mps2};
    }
  };
  /// The state from which a simulation can resume after an event.
  struct Checkpoint {
    Tick tick;
    std::size_t parts = 0;     ///< number of parts that began up to here
    std::size_t meetings = 0;  ///< number of meetings up to here
    std::uint64_t work = 0;    ///< work of its own events up to here
    Marble marble;
    RestState rest;
    std::size_t first_met = 0;  ///< index in `met`
    std::size_t met_count = 0;
  };
  /// An event that involved another ball.
  struct Meeting {
    Tick tick;
    BodyId partner{};
  };

  std::vector<Part> parts{};
  std::vector<Flight> flights{};  ///< by part
  std::vector<Checkpoint>
      checkpoints{};                ///< at its start, after meetings, and now and then between
  std::vector<Meeting> meetings{};  ///< in order of time
  Checkpoint last{};                ///< after its last event
  // Contact data of checkpoints.
  std::vector<TouchRecord> touches{};
  std::vector<RecentContacts::Entry> met{};
  std::uint64_t work = 0;  ///< work of its own events
  Tick until{};            ///< end of the known history
  bool stays = false;      ///< after `until` the ball stays at rest or left alone, unless met

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
  bool is_alone_at(Tick tick) const;
  /// Returns the last checkpoint before a tick, or null. Sets `is_gap` if meetings between the
  /// checkpoint and the tick have no checkpoint any more.
  const Checkpoint* checkpoint_before(Tick tick, bool& is_gap) const;
  std::size_t bytes() const {
    return sizeof(*this) + parts.capacity() * sizeof(Part) + flights.capacity() * sizeof(Flight) +
           checkpoints.capacity() * sizeof(Checkpoint) + meetings.capacity() * sizeof(Meeting) +
           touches.capacity() * sizeof(TouchRecord) +
           met.capacity() * sizeof(RecentContacts::Entry);
  }
};

}  // namespace sleight::physics
