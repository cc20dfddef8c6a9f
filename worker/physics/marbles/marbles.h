// Simulates equal balls on static geometry. Use it if only the balls' final positions are needed.
//
// Idea. Marbles omits parts of the simulator (simulation.h) that such scenes don't need: expiring
// bounding volumes, lists of watched pairs, a queue, a recording and orientations. When a ball's
// motion begins, its next collision with static geometry is fully determined at once. The path up
// to that collision has a box, and only pairs of balls with overlapping boxes are predicted. Each
// ball has one key, and the next event has the least key. If balls spell words in a scene, Marbles
// is three times as fast as a Simulation (docs/SIMULATOR, "Equal balls by themselves").
//
// Invariants
//   1. All results equal the results of a Simulation of the same scene, bit for bit. Marbles and
//      Simulation apply the same rules (collision_rule.h, contact_events.h, the responses) at the
//      same ticks in the same order (event.h). Tests compare them.
//   2. A ball's box contains the ball from now to its next event. Let two balls move, and let their
//      boxes not overlap. The balls can then meet only after the next event of one of them.
//   3. A ball that is left alone stays in its confinement, and no other ball's path comes near it.
//      When another ball comes near, the ball that was left alone catches up with the present.
//      Until then, no other ball has touched it.
//   4. Replayed balls aren't simulated. Replays change no result ("What stays the same", below).
//
// What stays the same. While recording, a simulation stores a history of each ball
// (marble_history.h): boxes, flights, meetings, and checkpoints from which the ball can resume.
// Another simulation can use these histories if its scene differs only in some balls or some static
// geometry. A ball with a history is replayed at no cost, until the first of these events:
//   1. The ball meets changed static geometry, or its history contains a collision with static
//      geometry that has changed.
//   2. In its history, the ball was left alone. Now its confinement would differ or be missing.
//   3. The ball's history contains a meeting with a ball that isn't replayed now.
//   4. In its history, the ball recently met a ball whose replay has since ended. Rest decisions
//      will read that other ball.
//   5. The ball rests on another ball that is no longer replayed, or such a ball rests on it.
//   6. A simulated ball meets the replayed ball, which is an obstacle with known motion. Or it
//      comes near the confinement in which the replayed ball is alone.
//   7. The ball's history ends, and the ball doesn't stay where it is.
//
// The ball then goes live: it is simulated from its last checkpoint on. Between the checkpoint and
// the present, the ball met only static geometry, so other balls aren't affected when it catches
// up. A history has a bounded number of checkpoints. The replay becomes void (is_replay_void()) if
// a checkpoint is missing, if there is an error, or if a large part of the permitted work is used
// up. If the replay is void, only a simulation without histories gives the result.
//
// After the start, once lists have grown, memory is allocated only for histories. Cost: with ten
// balls, an event takes some 6,000 instructions, below 1 microsecond. With n balls, it takes about
// 10 n instructions more. Thread safety: none.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/contact/recent_contacts.h"
#include "worker/physics/contact/resting.h"
#include "worker/physics/event/event.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/marbles/ball_boxes.h"
#include "worker/physics/marbles/marble_history.h"
#include "worker/physics/marbles/near_features.h"
#include "worker/physics/marbles/path_bounds.h"
#include "worker/physics/marbles/surroundings.h"
#include "worker/physics/response/contact_motion.h"
#include "worker/physics/response/sphere_impact.h"
#include "worker/physics/scene/scene.h"

namespace sleight::physics {

/// Called when a ball begins a motion. Returns a box that the ball, with k_touch_m around it, can't
/// leave unless another ball touches the ball. Returns nothing if there is no such box, or if the
/// caller needs the ball's motion. A ball with a box is left alone until another ball comes near
/// the box.
using MarbleConfinement =
    std::function<std::optional<Box>(BodyId marble, const Vec3& centre_m, const Twist& twist)>;

/// Returns whether Marbles can simulate a scene. All balls must have one size, mass and material.
/// Slow contacts must end. There must be no alternative starts, controls, periods, fixed bodies or
/// filtered groups.
bool are_marbles(const Scene& scene);

/// Histories by ball; null if unknown or if the ball itself differs.
using MarbleHistories = std::vector<std::shared_ptr<const MarbleHistory>>;

/// A place where static geometry may differ from another simulation's.
struct MarbleChange {
  std::span<const FeatureId> features;  ///< features that differ
  TouchBox box;  ///< a ball that meets one of them, in its old or new state, overlaps this box
};

/// Input from an earlier simulation. REQUIRES: all histories come from one simulation. The scene of
/// that simulation has the same laws, and the same static geometry except for `changes`. Each ball
/// with a history has the same properties and the same start there.
struct MarbleReplay {
  const MarbleHistories* histories = nullptr;  ///< by ball, from a finished simulation
  std::span<const MarbleChange> changes{};     ///< of static geometry
  bool confinement_differs = false;            ///< the confinement function may differ
  bool records = false;
};

class Marbles {
 public:
  struct Counts {
    std::uint64_t static_collisions = 0;
    std::uint64_t collisions = 0;
    std::uint64_t modes = 0;
    std::uint64_t rest_decisions = 0;
    std::uint64_t suspensions = 0;
    std::uint64_t resumptions = 0;

    std::uint64_t events() const { return static_collisions + collisions + modes + rest_decisions; }
    /// Work in units of events. A rest decision may take as long as several events.
    std::uint64_t work() const { return events() + (k_rest_work - 1) * rest_decisions; }
  };

  /// Begins before all events. Borrows `scene` and `near` until the next start. `end` is the last
  /// tick that run_until() may reach. If the work exceeds `work_max`, the simulation fails: wedged
  /// balls collide about a million times per second. REQUIRES: are_marbles(scene); error_of(scene)
  /// returns nothing; near is built for this scene's static geometry and radius.
  void start(const Scene& scene, const NearFeatures& near, Tick end,
             MarbleConfinement confinement = {}, std::uint64_t work_max = UINT64_MAX,
             const MarbleReplay& replay = {});
  /// Processes all events up to and at a tick. Returns nothing on success. After an error, the
  /// state stays as it is. If is_replay_void(), ignore the error. REQUIRES: `tick` is not beyond
  /// the end.
  std::optional<SceneError> run_until(Tick tick);

  Tick now() const { return now_; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(balls_.size()); }
  // All functions below REQUIRE that the ball has started.
  bool started(BodyId marble) const { return balls_[marble].started; }
  bool is_suspended(BodyId marble) const { return balls_[marble].suspended; }
  /// For a suspended ball, returns the mode at suspension.
  MotionMode mode(BodyId marble) const { return balls_[marble].segment.mode; }
  /// For a suspended ball, returns the segment that began at suspension.
  const Segment& segment(BodyId marble) const { return balls_[marble].segment; }
  /// At now(). REQUIRES: the ball isn't suspended.
  Vec3 position_m(BodyId marble) const { return position_at(balls_[marble].segment.flight, now_); }
  Twist twist(BodyId marble) const { return twist_at(marble, now_); }
  const Counts& counts() const { return counts_; }

  /// Returns the history of a replayed ball, otherwise null. Don't call the functions above for a
  /// replayed ball.
  const MarbleHistory* replayed(BodyId marble) const { return replayed_[marble].get(); }
  /// Simulates a ball from now on.
  void stop_replay(BodyId marble);
  /// Returns whether a simulation without histories might have other results.
  bool is_replay_void() const;
  /// Histories up to now, by ball. REQUIRES: recording is on; the replay isn't void.
  MarbleHistories histories() const;

 private:
  static constexpr BodyId k_none{UINT32_MAX};
  static constexpr FeatureId k_nothing = Marble::k_none;

  // State.
  bool meets_replayed(BodyId ball) const {
    return partners_[ball] != k_none && replayed_[partners_[ball]] != nullptr;
  }
  bool is_resting(BodyId ball) const { return balls_[ball].segment.mode == MotionMode::resting; }
  /// Returns the tick at which a ball's current motion ends, if no other ball meets it. For a ball
  /// at rest, returns now().
  Tick next_of(BodyId ball) const {
    const Marble& own = balls_[ball];
    return is_resting(ball) ? now_ : std::min({own.static_tick, own.supports.end, end_});
  }
  Twist twist_at(BodyId ball, Tick tick) const;
  Vec3 place_at(BodyId ball, Tick tick) const {
    return position_at(balls_[ball].segment.flight, tick);
  }
  void begin_segment(BodyId ball, const Segment& segment);
  void segment_begun(BodyId ball);  ///< call after writing the segment
  std::string name(BodyId ball) const;

  // Events (marbles.cpp).
  void process(const EventKey& event);
  void start_ball(BodyId ball, const EventKey& event);
  std::string obstacle_of(BodyId ball);
  void resume(const EventKey& present);
  void balls_changed();
  bool suspend(BodyId ball);
  void refresh_key(BodyId ball);
  void fail(SceneError::Kind kind, std::string message);

  // What happens (marbles_contacts.cpp).
  class AtEvent;
  const CollisionCount& count_at(BodyId ball, Tick tick);
  void collide(BodyId a, BodyId b, Tick tick);
  void collide_static(BodyId ball, FeatureId feature, Tick tick);
  void change_mode(BodyId ball, Tick tick);
  std::size_t rest(BodyId ball, Tick tick);

  // Storing histories (marbles_histories.cpp).
  void begin_history(BodyId ball);
  void keep_part(BodyId ball, const TouchBox& box);
  void keep_meeting(BodyId a, BodyId b);
  void keep_checkpoints(BodyId of);
  MarbleHistory::Checkpoint checkpoint_in(MarbleHistory& history, BodyId ball, Tick tick) const;

  // Replays (marbles_replays.cpp).
  void begin_replay(const MarbleReplay& replay);
  void goes_live(BodyId ball);
  void hasten_partners(BodyId ball, Tick now);
  void go_on_from(BodyId ball, const MarbleHistory& history,
                  const MarbleHistory::Checkpoint& checkpoint, Tick now);
  void keep_up_to(BodyId ball, const MarbleHistory& history,
                  const MarbleHistory::Checkpoint& checkpoint);
  void goes_live_by(BodyId ball, Tick tick);
  void hasten(std::size_t from);
  void comes_near_replayed(BodyId ball, const TouchBox& box, Tick to, bool is_path);
  void find_part_now(BodyId ball);
  Tick replayed_comes_near(const TouchBox& box);
  bool stays_alone(BodyId ball, const MarbleHistory::Part& part,
                   const MarbleHistory::Flight& way) const;
  Tick first_changed(BodyId ball, const MarbleReplay& replay, Tick until);
  /// The tick of the current event; it doesn't change while some balls catch up.
  Tick present() const { return catches_up_ ? present_ : now_; }

  // When balls meet something (marbles_predictions.cpp).
  void predict_static(BodyId ball);
  struct Window;
  Tick meets_face(const FreeFlight& flight, const SphereFeature& face, const Window& window,
                  double after_s);
  Tick gives_up(Tick tick);
  Tick meets_corner(const FreeFlight& flight, const SphereFeature& corner, const Window& window,
                    double after_s);
  void predict_pairs(BodyId ball);
  void comes_near(BodyId ball, const TouchBox& own, BodyId other);
  Tick predict_pair(BodyId a, BodyId b) const;
  Tick first_touch(const FreeFlight& first, const FreeFlight& second, Tick from, Tick until,
                   const Refractory& refractory) const;
  bool starts_at(BodyId ball, const MarbleHistory::Flight& way) const;
  Tick meets_way(BodyId ball, const MarbleHistory::Flight& way, MotionMode mode, Tick from,
                 Tick until) const;
  Tick first_met(const FreeFlight& flight, Tick from, Tick until, const MarbleChange& change);
  Refractory refractory_of(BodyId a, BodyId b, Tick begin) const;
  TouchBox way_box_of(const FreeFlight& flight, Tick from, Tick to) const;
  TouchBox path_box_of(BodyId ball, Tick from, Tick to) const {
    return way_box_of(balls_[ball].segment.flight, from, to);
  }
  bool way_meets(const FreeFlight& flight, Tick from, Tick to, const TouchBox& box,
                 int depth) const;
  bool path_meets(BodyId ball, Tick from, Tick to, const TouchBox& box, int depth) const {
    return way_meets(balls_[ball].segment.flight, from, to, box, depth);
  }

  const Scene* scene_ = nullptr;
  const NearFeatures* near_ = nullptr;
  const StaticGeometry* statics_ = nullptr;
  MarbleConfinement confinement_;
  Tick end_{};
  Tick now_{};
  std::uint64_t work_max_ = UINT64_MAX;
  // Common properties of all balls.
  double radius_m_ = 0;
  MaterialId material_{};
  Inertia inertia_;
  SphereMass mass_{};
  RoundBody round_;
  TickCount alone_for_ = 0;
  bool contacts_last_ = false;

  std::vector<Marble> balls_;
  std::vector<Surroundings> surroundings_;
  BallBoxes boxes_;             ///< of paths or confinements
  std::vector<EventKey> keys_;  ///< next event by ball
  /// For each ball: the partner that the ball meets next, at pair_tick. The partners of a replayed
  /// ball are in its history.
  std::vector<BodyId> partners_;
  Resting resting_;
  RecentContacts recent_;
  std::vector<BodyId> changed_;
  std::vector<BodyId> to_resume_;
  bool catches_up_ = false;
  Tick present_{};  ///< tick that balls catch up with
  // Histories.
  bool records_ = false;
  std::vector<MarbleHistory> kept_;               ///< of simulated balls, if recording
  std::vector<BodyId> met_;                       ///< balls of the current event to checkpoint
  MarbleHistories replayed_;                      ///< null: simulated
  std::vector<BodyId> replays_;                   ///< balls that are replayed, ascending
  std::vector<std::uint8_t> is_changed_feature_;  ///< by feature
  std::vector<std::size_t> part_now_;             ///< by replayed ball: current part of its history
  std::vector<std::uint64_t> own_work_;  ///< by ball: work of events in which it is the lower ball
  std::vector<Tick> last_event_;         ///< by ball
  std::vector<std::uint32_t> since_checkpoint_;    ///< by ball: events since its last checkpoint
  std::vector<std::pair<BodyId, Tick>> hastened_;  ///< scratch: balls that must go live, with ticks
  std::uint64_t replayed_work_ = 0;  ///< work before the checkpoints from which balls have resumed
  bool has_replayed_ = false;
  bool lacks_checkpoint_ = false;
  Counts counts_;
  std::optional<SceneError> failure_;
};

}  // namespace sleight::physics
