// A running simulation's bodies and static geometry. World computes the effects of events:
// collisions, lasting contact, rest. World doesn't use queues or bounding volumes.
//
// `Bodies` stores how each body moves now. `MetStatics` finds the static geometry that a body may
// meet. `Predictions` computes when bodies meet. `Recorder` stores what happened. `World` computes
// what happens when bodies meet.
//
// Invariants
//   1. Whenever a body's motion changes, the recorder is notified, and contacts found by
//      predictions become void. If all bodies are spheres, predictions find no contacts in advance
//      (collide_plain).
//   2. If anything outside its history is about to change a replayed body (replay.h) or to read its
//      state, the body is made live first.
// Thread safety: none.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "worker/physics/contact/contact_state.h"
#include "worker/physics/contact/impact_noise.h"
#include "worker/physics/contact/impacts.h"
#include "worker/physics/contact/plane_stay.h"
#include "worker/physics/contact/resting.h"
#include "worker/physics/contact/surface_touches.h"
#include "worker/physics/reuse/history.h"
#include "worker/physics/reuse/recorder.h"
#include "worker/physics/reuse/replayed_bodies.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/simulator/bodies.h"
#include "worker/physics/simulator/met_statics.h"
#include "worker/physics/simulator/predictions.h"

namespace sleight::physics {

class World {
 public:
  /// Copies the scene and borrows nothing.
  World(const Scene& scene, bool record, std::size_t segments_reserved);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  Bodies& bodies() { return bodies_; }
  const Bodies& bodies() const { return bodies_; }
  const MetStatics& statics() const { return statics_; }
  Predictions& predictions() { return predictions_; }
  Recorder& recorder() { return recorder_; }
  const Resting& resting() const { return resting_; }
  ReplayedBodies& replayed() { return replayed_; }
  std::span<const SurfaceTouch> surface_touches() const { return surface_touches_; }
  /// Lists impacts from now on.
  void keep_impacts() { keeps_impacts_ = true; }
  std::span<const Impact> impacts() const { return impacts_; }
  /// Returns what a collision's first body meets, as Impact::higher.
  std::uint32_t partner_of(const EventKey& event) const {
    return event.is_with_static() ? k_static | statics_.object(event.body(), event.met())
                                  : event.higher;
  }
  /// Returns what failed in a prediction or a collision. Empty if nothing failed.
  const std::optional<SceneError>& failure();
  bool has_failed() const { return failure_ || predictions_.gave_up(); }

  // Bodies that start.
  /// Puts a body at a place, to test whether there is room. Doesn't record it.
  void place(BodyId body, const Segment& segment);
  void begin_segment(BodyId body, const Segment& segment, const EventKey& cause);
  // Fixed bodies, and bodies that start at rest (world_at_rest.cpp).
  /// Places them, and finds what carries those that start at rest. Returns an error if such a body
  /// can't rest there. REQUIRES: nothing has happened yet.
  std::optional<SceneError> lay_down();
  Segment segment_at_rest(BodyId body) const;
  /// Puts a body to rest after its segment has begun. REQUIRES: lay_down().
  void begin_at_rest(BodyId body);

  // Events. After each function below, changed() lists the bodies that began a segment, ascending.
  // REQUIRES: the event was predicted for its tick.
  void collide(BodyId a, BodyId b, const EventKey& event);
  void collide_static(BodyId body, StaticId met, const EventKey& event);
  void apply(const Control& control, const EventKey& event);
  /// Processes the body's rest event. If the rules allow, puts the body and the bodies that it
  /// leans on to rest. Returns the number of bodies that went to rest.
  std::size_t rest(BodyId body, const EventKey& event);
  /// Processes the body's mode event: its contact with static geometry changes. REQUIRES: it stays
  /// on faces.
  void change_mode(BodyId body, const EventKey& event);
  /// Replays an event of a history. REQUIRES: its participants are replayed.
  void happens_again(const HistoryEvent& event);
  /// Replays an event without moving the bodies. After many such events, call is_by_now() to move
  /// each body to its last segment.
  void passes(const HistoryEvent& event);
  void is_by_now(BodyId body, const Segment& segment);
  std::span<const BodyId> changed() const { return changed_; }
  void nothing_changed() { changed_.clear(); }

  /// Whether all bodies are spheres that only fly and collide. No body is fixed. The scene has no
  /// rest speed, so the spheres never rest. It has no separation speed, so they never stay on
  /// anything.
  bool only_flies() const {
    return bodies_.only_spheres() && bodies_.fixed().empty() && !resting_.enabled() &&
           !predictions_.contacts_matter();
  }

  // Ticks of a body's own events; k_never if there are none.
  /// If the body is in contact, returns when its contact's law changes. Otherwise returns the last
  /// tick for which the body's free rotation can be computed.
  Tick mode_end(BodyId body) const {
    if (!has_modes_) return k_never;
    if (bodies_.is_sphere(body) || bodies_.stays_on_faces(body))
      return bodies_.may_stay() ? bodies_.supports(body).end : k_never;
    return bodies_.constants(body).inertia.symmetry == InertiaSymmetry::general
               ? bodies_.rotation_horizon(body)
               : k_never;
  }
  Tick rest_due(BodyId body) const { return resting_.enabled() ? resting_.due(body) : k_never; }

  // Histories.
  /// Stores an event in the history. Call at the end of the event.
  void keep(const EventKey& event) {
    if (recorder_.keeps_history()) append_to_history(event);
  }
  /// Returns the history up to now. Null if the history isn't stored, exceeded the memory limit, or
  /// is incomplete after a failure.
  std::shared_ptr<const History> history(Tick now);

  /// Prefetches data of a body's collision.
  void fetch(BodyId body) const {
    bodies_.fetch(body);
    __builtin_prefetch(&collided_[body], 1);
  }

 private:
  /// The table of bodies that contact_events.h uses (world_at_event.h).
  class AtEvent;

  // Collisions (world_collisions.cpp).
  /// Equals collide(), bit for bit, but causes less memory traffic. REQUIRES: a world of plain
  /// spheres; two spheres in flight that don't turn.
  void collide_plain(BodyId a, BodyId b, const EventKey& event);
  /// Collisions of fixed bodies aren't counted.
  const CollisionCount& count_at(BodyId body, Tick tick) {
    if (bodies_.is_fixed(body)) return collided_[body];
    collided_[body].add(tick);
    if (collided_[body].is_too_much()) [[unlikely]]
      note_too_much(body, tick);
    return collided_[body];
  }
  void note_too_much(BodyId body, Tick tick);
  void note_failure(SceneError::Kind kind, const std::string& what, BodyId body, Tick tick);
  std::string message_of(const std::string& what, BodyId body, Tick tick) const;
  /// Call before and after a collision changes the bodies. Lists the impact if impacts are kept.
  void begin_impact(const EventKey& event);
  void end_impact();
  /// See AnyAtEvent. REQUIRES: begin_impact(), and both bodies' collisions are counted.
  std::optional<ImpactNoise> take_noise();
  /// Number of the pair's noised impacts so far. REQUIRES: the scene has noise.
  std::uint32_t& noised(std::uint32_t lower, std::uint32_t higher);
  /// Records that a body touched a surface at centre_m + arm_m.
  void note_surface(BodyId body, StaticId met, Tick tick, const Vec3& centre_m, const Vec3& arm_m);

  // Rest (world_rest.cpp).
  /// For the rest decision: if a corner touched, records the corners near it, which carry the body
  /// too.
  void note_near_corners(BodyId body, Tick tick);
  /// Calls found(touch) for each corner within near_m of the face on which `touch` was.
  void corners_like(BodyId body, const TouchRecord& touch, Tick tick, double near_m,
                    const std::function<void(const TouchRecord&)>& found);

  // Starts at rest (world_at_rest.cpp).
  bool is_static(BodyId partner) const {
    return partner == k_static_partner || bodies_.is_fixed(partner);
  }
  struct RestTouch;
  void find_rest_touches(BodyId body, std::vector<RestTouch>& found,
                         std::optional<SceneError>& error);
  SceneError error_of_rest(BodyId body, double missing, bool holds_if_rough,
                           const std::vector<RestTouch>& touches) const;
  std::optional<SceneError> lay_down_structure(std::span<const BodyId> members,
                                               const std::vector<RestTouch>& touches);

  // Functions for bodies that stay on planes (world_planes.cpp).
  struct PlaneSupports {
    std::array<PlaneSupport, k_plane_supports_max> all;
    std::size_t count = 0;
    double lowest_m = 0;  ///< lowest corner above the flat surface; at most 0
  };
  PlaneSupports supports_on(BodyId body, StaticId met, const Flat& flat, Tick tick);
  /// Returns how a body with this twist stays on the static geometry that it touches. Empty if it
  /// doesn't.
  std::optional<PlaneStay> stay_of(BodyId body, StaticId met, std::uint32_t face,
                                   const Twist& twist, Tick tick);
  /// For the rest decision: if a body stays on a plane, records what carries it.
  void note_plane_supports(BodyId body, Tick tick);

  // Histories (world_history.cpp).
  void append_to_history(const EventKey& event);
  /// Gives the participants the contact state that the history has for them after the event.
  /// REQUIRES: their segments have begun.
  void restore(const HistoryEvent& event);
  void restore_surface(const HistoryEvent& event);

  const Scene& scene() const { return bodies_.scene(); }

  Bodies bodies_;
  MetStatics statics_;
  Predictions predictions_;
  Recorder recorder_;
  ReplayedBodies replayed_;
  Resting resting_;
  TickCount alone_for_ = 0;  ///< a sphere stays only if it has met no body for this long
  std::vector<CollisionCount> collided_;  ///< by body
  std::vector<BodyId> changed_;
  std::vector<SurfaceTouch> surface_touches_;
  bool keeps_impacts_ = false;
  std::vector<Impact> impacts_;
  Impact impact_;  ///< the current collision
  struct PairCount {
    std::uint32_t higher = 0;
    std::uint32_t count = 0;
  };
  std::vector<std::vector<PairCount>> noised_;  ///< by Impact::lower; empty if there is no noise
  struct AtRest {
    std::vector<TouchRecord> touches;
    std::vector<BodyId> supporters;
  };
  std::vector<AtRest> at_rest_;  ///< by body, at its start; empty if no body starts at rest
  std::optional<SceneError> failure_;
  bool has_modes_ = false;  ///< some bodies may have mode events
  /// Empty unless all bodies are spheres of one frictionless material and only fly.
  std::vector<double> plain_inverse_masses_per_kg_;
};

}  // namespace sleight::physics
