// Equal balls on static geometry, for callers that want to know where balls end up and nothing
// else.
//
// Idea. The simulator (simulation.h) without the parts that such scenes don't need: no bounding
// volumes that expire, no list of watched pairs, no queue, no recording, no orientations.
// A ball's next collision with static geometry is found to its end, once, when its motion begins:
// then its path up to there has a box, and only balls whose boxes overlap are asked when they meet.
// The next event of all is the least of one number per ball. That makes it three times as fast as a
// Simulation of balls that spell (docs/SIMULATOR, "Equal balls by themselves").
//
// Invariants
//   1. Everything that happens is what happens in a Simulation of the same scene, bit for bit: the
//      same rules (collision_rule.h, contact_events.h, the responses) are asked at the same ticks
//      in the same order (event.h). tests compare them.
//   2. A ball's box holds it from now to its own next event. The boxes of two balls that are not
//      at rest overlap, or the two don't meet before the next event of one of them.
//   3. A ball that is left alone is in its confinement, which no other ball's path comes near. It
//      catches up with the present when one does: until then nothing else has touched it.
//   4. What is replayed is not simulated, and makes no difference ("What stays the same", below).
//
// What stays the same. A simulation that records keeps a history of each ball: the boxes that it
// was in and its flights there, its meetings, and checkpoints, from which all goes on
// (marble_history.h). A simulation of a scene that differs in some balls, or in static geometry
// here and there, can be given these histories. A ball that has one is replayed, which costs
// nothing, until the first of these:
//   - it meets static geometry that has changed, or in its history met some that has changed since;
//   - it was left alone in its history and would not be now, or in another confinement;
//   - its history has a meeting with a ball that isn't replayed now, or has just had one with a
//   ball
//     that has gone live since: decisions about rest will ask about that ball;
//   - a ball that it rests on, or that rests on it, isn't replayed any more;
//   - a ball that isn't replayed meets it (it is an obstacle that moves in a known way), or comes
//     near the confinement in which it is alone;
//   - its history ends, and the ball doesn't stay where it is.
// Then it goes live from its last checkpoint. Between that and the present it was alone with static
// geometry, so catching up changes nothing for others. A history has a bounded number of
// checkpoints. If one is missing, after any error, or when a good part of the permitted work is
// used up, the replay is void (is_replay_void()), and only a simulation of everything gives the
// result.
//
// Nothing is allocated after start once lists have grown, but for histories. Cost: some 6,000
// instructions per event among ten balls, below 1 microsecond; of n balls some 10 n more. Thread
// safety: none.
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

/// Asked when a ball begins a motion with its centre at a place. A box that the ball, and k_touch_m
/// around it, can't leave unless another ball touches it; nothing if there is none, or if what the
/// ball does is of interest. The ball is then left alone until another one comes near that box.
using MarbleConfinement =
    std::function<std::optional<Box>(BodyId marble, const Vec3& centre_m, const Twist& twist)>;

/// Whether a scene is for marbles: balls of one size, mass and material whose slow contacts end,
/// that don't draw their starts again; no controls, no periods.
bool are_marbles(const Scene& scene);

/// By ball; null where nothing is known, or the ball itself is another one.
using MarbleHistories = std::vector<std::shared_ptr<const MarbleHistory>>;

/// Where static geometry may be otherwise than in another simulation.
struct MarbleChange {
  std::span<const FeatureId> features;  ///< which
  TouchBox box;  ///< a ball overlaps it if it meets one of them, as that was or is
};

/// What is known before a simulation begins, and what shall be known afterwards. REQUIRES:
/// histories are of one simulation; what is the same of its scene are static geometry but for
/// changes, the laws, the balls and the starts of those with a history.
struct MarbleReplay {
  const MarbleHistories* histories = nullptr;  ///< of all balls, of a simulation that is over
  std::span<const MarbleChange> changes{};     ///< of static geometry
  bool confinement_differs = false;            ///< it may say something else of a place and a twist
  bool records = false;
};

class Marbles {
 public:
  /// Events so far.
  struct Counts {
    std::uint64_t static_collisions = 0;
    std::uint64_t collisions = 0;
    std::uint64_t modes = 0;
    std::uint64_t rest_decisions = 0;
    std::uint64_t suspensions = 0;
    std::uint64_t resumptions = 0;

    std::uint64_t events() const { return static_collisions + collisions + modes + rest_decisions; }
    /// In events: a decision about rest may take as long as some.
    std::uint64_t work() const { return events() + (k_rest_work - 1) * rest_decisions; }
  };

  /// Begins before everything. Borrows the scene, and what is near, until the next start.
  /// `end`: no one asks for anything later. `work_max`: more than that is an error, as balls that
  /// are wedged collide some million times in a second. REQUIRES: are_marbles(scene);
  /// error_of(scene) has none; `near` is of this scene's static geometry and radius.
  void start(const Scene& scene, const NearFeatures& near, Tick end,
             MarbleConfinement confinement = {}, std::uint64_t work_max = UINT64_MAX,
             const MarbleReplay& replay = {});
  /// Processes all events up to and at a tick. Nothing if all went well; the engine stays where it
  /// is after an error, which means nothing if is_replay_void(). REQUIRES: not beyond the end.
  std::optional<SceneError> run_until(Tick tick);

  Tick now() const { return now_; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(balls_.size()); }
  // REQUIRES, of the rest: the ball has started.
  bool started(BodyId marble) const { return balls_[marble].started; }
  bool is_suspended(BodyId marble) const { return balls_[marble].suspended; }
  /// At present; of a ball that is suspended, when it was.
  MotionMode mode(BodyId marble) const { return balls_[marble].segment.mode; }
  /// The present motion; of a ball that is suspended, the one that it began when it was.
  const Segment& segment(BodyId marble) const { return balls_[marble].segment; }
  /// At now(). REQUIRES: not suspended.
  Vec3 position_m(BodyId marble) const { return position_at(balls_[marble].segment.flight, now_); }
  Twist twist(BodyId marble) const { return twist_at(marble, now_); }
  const Counts& counts() const { return counts_; }

  /// The history that a ball is replayed by at present, null if by none: then nothing of the above
  /// may be asked for.
  const MarbleHistory* replayed(BodyId marble) const { return replayed_[marble].get(); }
  /// Simulates a ball from the present on.
  void stop_replay(BodyId marble);
  /// Whether what happened isn't known to be what would happen without histories.
  bool is_replay_void() const;
  /// What has happened so far: of all balls. REQUIRES: it records; the replay isn't void.
  MarbleHistories histories() const;

 private:
  static constexpr BodyId k_none{UINT32_MAX};
  static constexpr FeatureId k_nothing = Marble::k_none;

  // State.
  bool meets_replayed(BodyId ball) const {
    return partners_[ball] != k_none && replayed_[partners_[ball]] != nullptr;
  }
  bool is_resting(BodyId ball) const { return balls_[ball].segment.mode == MotionMode::resting; }
  /// Up to when a ball's present motion goes on, other balls apart; of one at rest, the present.
  Tick next_of(BodyId ball) const {
    const Marble& own = balls_[ball];
    return is_resting(ball) ? now_ : std::min({own.static_tick, own.supports.end, end_});
  }
  Twist twist_at(BodyId ball, Tick tick) const;
  Vec3 place_at(BodyId ball, Tick tick) const {
    return position_at(balls_[ball].segment.flight, tick);
  }
  void begin_segment(BodyId ball, const Segment& segment);
  void segment_begun(BodyId ball);  ///< after its segment was written
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

  // Keeping histories (marbles_histories.cpp).
  void begin_history(BodyId ball);
  void keep_part(BodyId ball, const TouchBox& box);
  void keep_meeting(BodyId a, BodyId b);
  void keep_checkpoints(BodyId of);
  MarbleHistory::Checkpoint checkpoint_in(MarbleHistory& history, BodyId ball, Tick tick) const;

  // What is replayed (marbles_replays.cpp).
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
  /// The tick of what takes place, also while some catch up with it.
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
  // Of all balls.
  double radius_m_ = 0;
  MaterialId material_{};
  Inertia inertia_;
  SphereMass mass_{};
  RoundBody round_;
  TickCount alone_for_ = 0;
  bool contacts_last_ = false;

  std::vector<Marble> balls_;
  std::vector<Surroundings> surroundings_;
  BallBoxes boxes_;             ///< of paths, or of confinements
  std::vector<EventKey> keys_;  ///< of each ball's next event
  /// By ball: its next partner, if it meets one at pair_tick; a replayed ball's is its history's.
  std::vector<BodyId> partners_;
  Resting resting_;
  RecentContacts recent_;
  std::vector<BodyId> changed_;
  std::vector<BodyId> to_resume_;
  bool catches_up_ = false;
  Tick present_{};  ///< that they catch up with
  // MarbleHistories.
  bool records_ = false;
  std::vector<MarbleHistory> kept_;               ///< of those that are simulated, if it records
  std::vector<BodyId> met_;                       ///< at the present event
  MarbleHistories replayed_;                      ///< null: simulated
  std::vector<BodyId> replays_;                   ///< those that aren't null, ascending
  std::vector<std::uint8_t> is_changed_feature_;  ///< by feature
  std::vector<std::size_t> part_now_;             ///< of each replayed ball's history
  std::vector<std::uint64_t> own_work_;  ///< by ball: of events of which it is the lower one
  std::vector<Tick> last_event_;         ///< by ball
  std::vector<std::uint32_t> since_checkpoint_;    ///< by ball: events since its last checkpoint
  std::vector<std::pair<BodyId, Tick>> hastened_;  ///< scratch: balls going live, by when
  std::uint64_t replayed_work_ = 0;  ///< of events before the checkpoints that some went on from
  bool has_replayed_ = false;
  bool lacks_checkpoint_ = false;
  Counts counts_;
  std::optional<SceneError> failure_;
};

}  // namespace sleight::physics
