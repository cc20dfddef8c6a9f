// The bodies of a running simulation: what they are, how they move now, when a pair of them meets
// and what a collision does to them. Knows nothing of queues and bounding volumes.
//
// Invariants
//   1. Every prediction is a function of the segments of the bodies involved: it does not depend on
//      the caller or on the time of the call.
//   2. A body's motion changes only through begin_segment, which also records it.
// Thread safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "worker/physics/collision/near_places.h"
#include "worker/physics/collision/piece_searches.h"
#include "worker/physics/collision/surface_search.h"
#include "worker/physics/contact/contact_state.h"
#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/contact/plane_stay.h"
#include "worker/physics/contact/recent_contacts.h"
#include "worker/physics/contact/resting.h"
#include "worker/physics/contact/surface_touches.h"
#include "worker/physics/motion/motion_bounds.h"
#include "worker/physics/motion/rotation_track.h"
#include "worker/physics/response/contact_motion.h"
#include "worker/physics/response/rigid_impact.h"
#include "worker/physics/response/sphere_impact.h"
#include "worker/physics/reuse/history.h"
#include "worker/physics/reuse/history_builder.h"
#include "worker/physics/reuse/recording.h"
#include "worker/physics/reuse/replay.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/scene/static_geometry.h"
#include "worker/physics/simulator/lanes.h"
#include "worker/physics/simulator/pair_graph.h"

namespace sleight::physics {

/// What predictions of spheres read, in one cache line.
struct alignas(64) Flight {
  Vec3 position_m = Vec3::Zero();
  Vec3 velocity_mps = Vec3::Zero();
  Tick begin{};
  double radius_m = 0;  ///< of a sphere in flight; 0 for whatever has no closed form
};
static_assert(sizeof(Flight) == 64);

/// What doesn't change; what spheres need comes first, in one cache line.
struct alignas(64) BodyConstants {
  SphereMass sphere_mass{};  ///< of a sphere
  double reach_m = 0;        ///< radius of a sphere about the centre that holds the body
  MaterialId material{};
  bool is_sphere = true;
  bool has_round_parts = false;  ///< balls and rings (round_piece.h)
  std::uint32_t first_part = 0;  ///< its convex parts in the table of all; a sphere has one point
  std::uint32_t part_count = 1;
  /// One view for several parts (hull_of), in the table of these. k_no_hull: none.
  std::uint32_t hull = k_no_hull;
  static constexpr std::uint32_t k_no_hull = UINT32_MAX;
  Vec3 axis = Vec3::Zero();  ///< of a body of revolution, in its frame; else 0
  Inertia inertia;
  RigidMass rigid_mass{};
};

/// The way of a body's centre (OnParabola in motion_bounds.h).
struct Path {
  Tick begin{};
  Vec3 position_m = Vec3::Zero();
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 acceleration_mps2 = Vec3::Zero();
};

/// A spline surface of the scene.
struct MetSurface {
  std::string name;  ///< for people
  SplineSurface surface;
  std::vector<BoxLattice> lattices;  ///< of all bodies' parts, in their order
  std::vector<NearPoints> near;      ///< the same
};

class World {
 public:
  /// Borrows nothing: the scene is copied.
  World(const Scene& scene, bool record, std::size_t segments_reserved);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  std::uint32_t size() const { return static_cast<std::uint32_t>(flights_.size()); }
  const Scene& scene() const { return scene_; }
  const Segment& segment(std::uint32_t body) const { return segments_[body]; }
  /// Of the segment, without a look at the rest of it where that is a sphere in flight.
  Path path(std::uint32_t body) const {
    const Flight& flight = flights_[body];
    return {.begin = flight.begin,
            .position_m = flight.position_m,
            .velocity_mps = flight.velocity_mps,
            .acceleration_mps2 = flight.radius_m > 0 ? scene_.gravity_mps2
                                                     : segments_[body].flight.acceleration_mps2};
  }
  /// Radius of a sphere about the centre that holds the body.
  double reach_m(std::uint32_t body) const {
    const double radius_m = flights_[body].radius_m;
    return radius_m > 0 ? radius_m : constants_[body].reach_m;
  }
  /// Up to the last event. Its end is the caller's affair.
  Recording& recording();
  bool periodic() const { return periodic_; }
  bool started(std::uint32_t body) const { return started_[body] != 0; }
  /// For people.
  std::string name(std::uint32_t body) const;

  Segment segment_of_start(const StartState& start, Tick tick) const;
  // Bodies that start at rest (world_at_rest.cpp).
  /// Finds what carries them; why they can't, if they can't. REQUIRES: nothing has happened yet.
  std::optional<SceneError> lay_down();
  Segment segment_at_rest(std::uint32_t body) const;
  /// Such a body has begun its segment. REQUIRES: lay_down().
  void begin_at_rest(std::uint32_t body);
  /// Puts a body somewhere without a trace in the recording, to see whether it has room there.
  void place(std::uint32_t body, const Segment& segment);
  void begin_segment(std::uint32_t body, const Segment& segment, const EventKey& cause);

  bool has_statics() const { return has_statics_; }
  bool is_sphere(std::uint32_t body) const { return constants_[body].is_sphere; }
  // What static geometry a body may meet. Indices are a body's own affair: spheres meet features,
  // others pieces, and after these surfaces.
  std::uint32_t static_count(std::uint32_t body) const;
  void statics_near(std::uint32_t body, const Box& box, std::vector<std::uint32_t>& found) const;
  /// Of some of these, in their order, what it may meet in a box.
  void statics_in(std::uint32_t body, const Box& box, std::span<const std::uint32_t> some,
                  std::vector<std::uint32_t>& found) const;
  const std::string& static_name(std::uint32_t body, std::uint32_t index) const;

  // Predictions. `search` keeps what a search of convex pieces has done so far; it is taken when
  // first needed and released by end_search.
  /// When the pair collides next, as its two segments say. REQUIRES: a < b; nothing happens to the
  /// pair between the later begin of their segments and `now`.
  Prediction predict(std::uint32_t a, std::uint32_t b, Tick now, std::uint32_t& search);
  /// Whether both are spheres in flight, in a scene without slow contacts: a closed form.
  bool free_spheres(std::uint32_t a, std::uint32_t b) const {
    return flights_[a].radius_m > 0 && flights_[b].radius_m > 0 && !recent_.enabled();
  }
  /// Hints to read soon what predictions need of a body, and what its collision does.
  void fetch_flight(std::uint32_t body) const { __builtin_prefetch(&flights_[body]); }
  void fetch(std::uint32_t body) const {
    __builtin_prefetch(&flights_[body], 1);
    __builtin_prefetch(&segments_[body], 1);
    __builtin_prefetch(&segments_[body].flight.velocity_mps[2], 1);
    __builtin_prefetch(&constants_[body]);
    __builtin_prefetch(&collided_[body], 1);
  }
  /// Whether predict_flight is for this body.
  bool in_free_flight(std::uint32_t body) const {
    return flights_[body].radius_m > 0 && !recent_.enabled();
  }
  /// The closed form. In a periodic world it is for the image that is nearest at `now`.
  /// REQUIRES: free_spheres(a, b); a < b.
  Prediction predict_free_spheres(std::uint32_t a, std::uint32_t b, Tick now) const;
  /// The same for the image of b at a shift.
  Prediction predict_free_spheres_at(std::uint32_t a, std::uint32_t b, const Vec3& shift_m) const;
  /// predict_free_spheres for some edges of a body; `changes` are of all bodies. False if some of
  /// the others are not in free flight: those edges are predicted as not colliding, and the caller
  /// must do them again. REQUIRES: in_free_flight(body).
  bool predict_flight(std::uint32_t body, std::span<PairEdge> edges,
                      std::span<const std::uint32_t> changes, Tick now) const;
  /// Goes on with a prediction that was not certain. REQUIRES: its tick is `now`.
  Prediction look(std::uint32_t a, std::uint32_t b, Tick now, std::uint32_t search);
  Prediction predict_static(std::uint32_t body, std::uint32_t index, Tick now,
                            std::uint32_t& search, Tick until);
  Prediction look_static(std::uint32_t body, std::uint32_t index, Tick now, std::uint32_t search,
                         Tick until);
  void end_search(std::uint32_t& search) { searches_.release(search); }
  /// Ends all. From now on searches may, or may not, leave out pairs that stay near places in which
  /// they are clear of each other (near_places.h).
  void forget_searches(bool use_places);
  /// As predict, for the periodic image that collides first: for the algorithm without boxes.
  /// REQUIRES: the world is periodic.
  Prediction predict_any_image(std::uint32_t a, std::uint32_t b, Tick now) const;

  // What happens; changed() then lists the bodies that began a segment, ascending.
  // REQUIRES: predicted for the event's tick.
  void collide(std::uint32_t a, std::uint32_t b, const EventKey& event);
  void collide_static(std::uint32_t body, std::uint32_t index, const EventKey& event);
  void apply(const Control& control, const EventKey& event);
  /// The body's rest event: it and those it leans on go to rest, if they may. How many did.
  std::size_t rest(std::uint32_t body, const EventKey& event);
  /// The body's mode event: its contact with static geometry changes. REQUIRES: stays_on_faces.
  void change_mode(std::uint32_t body, const EventKey& event);
  /// Whether the body slides or rolls on static geometry.
  bool stays_on_faces(std::uint32_t body) const { return in_contact(segments_[body]); }
  /// When the body's mode event is due: the law of its contact changes, or its free rotation can't
  /// be computed any further; k_never if neither.
  Tick mode_end(std::uint32_t body) const {
    if (!has_modes_) return k_never;
    if (constants_[body].is_sphere || stays_on_faces(body))
      return supports_.empty() ? k_never : supports_[body].end;
    return constants_[body].inertia.symmetry == InertiaSymmetry::general
               ? turning_[body].track.horizon()
               : k_never;
  }
  /// What went wrong in a prediction or a collision; empty if nothing did.
  const std::optional<SceneError>& failure() const { return failure_; }
  std::span<const std::uint32_t> changed() const { return changed_; }
  /// When the body's rest event is due; k_never if it has none.
  Tick rest_due(std::uint32_t body) const {
    return resting_.enabled() ? resting_.due(body) : k_never;
  }

  // Keeping a history (world_replay.cpp).
  /// From now on, for history(). REQUIRES: nothing has happened yet.
  void begin_history(std::size_t bytes_max, bool records);
  /// An event is over.
  void keep(const EventKey& event) {
    if (history_builder_) append_to_history(event);
  }
  /// All that happened up to now; null if it isn't kept, is too much, or something went wrong.
  std::shared_ptr<const History> history(Tick now);

  // Replaying the history of another simulation (replay.h).
  /// REQUIRES: nothing has happened yet.
  void begin_replay(std::shared_ptr<const History> history);
  bool replays() const { return replay_ != nullptr; }
  /// Nothing but what the history has happens before this tick. REQUIRES: replays().
  Tick quiet_until() const { return replay_->quiet_until; }
  /// All that happens before that tick, and up to and at `end`; up to where that was. REQUIRES:
  /// replays(); no other events were processed.
  Tick skip_quiet(Tick end);
  bool is_replayed(std::uint32_t body) const {
    return replayed_count_ != 0 && replayed_[body] != 0;
  }
  /// A body has started: whether it is replayed from now on.
  bool replays_start(std::uint32_t body, const EventKey& event);
  /// Whether no body is replayed, or will be.
  bool replay_is_over() const { return replayed_count_ == 0 && replay_->awaited_count == 0; }
  void end_replay() { replay_ = nullptr; }
  // REQUIRES, of these: replays().
  /// The key of the history's next event of bodies that are replayed; or of its end.
  EventKey next_replayed();
  /// Replays the next event if all its participants are replayed; otherwise makes those that are
  /// live. Whether it was replayed: changed() then lists the bodies that began a segment.
  bool play();
  /// How many of the scene's controls, in order, are the history's.
  std::size_t same_controls() const { return replay_->changes.same_controls; }
  /// A replayed body comes near a place where static geometry differs, if it does: it goes live.
  void comes_into(std::uint32_t body, const Box& box) {
    if (is_replayed(body) && replay_->changes.places.meet(box)) make_live(body);
  }
  bool statics_differ() const { return replay_ && !replay_->changes.places.none(); }
  void make_live(std::uint32_t body);
  /// Bodies that have gone live since the last forget_gone_live.
  bool has_gone_live() const { return !gone_live_.empty(); }
  std::span<const std::uint32_t> bodies_gone_live();
  void forget_gone_live() { gone_live_.clear(); }

  /// Whether the two touch or overlap at a tick.
  bool touching(std::uint32_t a, std::uint32_t b, Tick tick);
  bool touching_static(std::uint32_t body, std::uint32_t index, Tick tick);
  /// The static solid that the body's centre is in, by name; empty if none. A body deep inside of
  /// one may touch nothing of it.
  std::string solid_around(std::uint32_t body, Tick tick) const {
    return solid_at(position_at(segments_[body].flight, tick));
  }
  std::string solid_at(const Vec3& place_m) const;

  /// Within what time, to be counted from a tick, a body may move by a number of its radii.
  TickCount span_of_travel(std::uint32_t body, Tick tick, double radii) const;
  /// A span, or as much of it as a body may have one box for, which is its path's with a pad all
  /// around. In a periodic world two bodies whose boxes overlap must be nearer to one another than
  /// to other images, which to_nearest_image counts on: their centres are apart by at most the sum
  /// of both boxes' edges less both radii, and that is kept below half a period.
  TickCount limited_span(std::uint32_t body, Tick tick, TickCount span, double pad_radii) const;
  /// The edge of most boxes.
  double typical_box_m() const;

  MovingPoint centre_at(std::uint32_t body, Tick tick) const;
  Quat orientation_at(std::uint32_t body, Tick tick);
  Pose pose_at(std::uint32_t body, Tick tick);
  Twist twist_at(std::uint32_t body, Tick tick);
  /// Of all bodies that have started.
  double kinetic_energy_j(Tick tick);
  std::span<const SurfaceTouch> surface_touches() const { return surface_touches_; }

 private:
  /// As contact_events.h asks for bodies (world_at_event.h).
  class AtEvent;

  /// What bodies that are not spheres need beside their segment.
  struct Turning {
    RotationTrack track;
    RotationBounds bounds;
    Tick placed_at{-1};  ///< of the rest
    Quat orientation = Quat::Identity();
    MovingPiece placed;  ///< without a view
  };

  /// What to add to a vector to have its shortest image; whole periods.
  Vec3 to_nearest_image(const Vec3& between_m) const {
    Vec3 shift_m = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      const double period_m = scene_.period_m[static_cast<std::size_t>(i)];
      if (std::fabs(between_m[i]) <= 0.5 * period_m || period_m == 0) continue;
      shift_m[i] = -period_m * std::floor(between_m[i] / period_m + 0.5);
    }
    return shift_m;
  }
  /// A place within the periods.
  Vec3 wrapped_m(const Vec3& place_m) const;
  static Vec3 position_on(const Path& path, Tick tick) {
    const double s = seconds(tick - path.begin);
    Vec3 place_m;
    for (int i = 0; i < 3; ++i)
      place_m[i] = parabola(path.position_m[i], path.velocity_mps[i], path.acceleration_mps2[i], s);
    return place_m;
  }
  /// From a's centre to that of b's nearest image.
  Vec3 between_at(std::uint32_t a, std::uint32_t b, Tick tick) const {
    const Vec3 between_m =
        position_at(segments_[b].flight, tick) - position_at(segments_[a].flight, tick);
    return periodic_ ? Vec3(between_m + to_nearest_image(between_m)) : between_m;
  }
  const MovingPiece& moving_at(std::uint32_t body, Tick tick);
  MovingPiece part_at(std::uint32_t body, std::uint32_t part, Tick tick);
  Segment segment_after(std::uint32_t body, Tick tick, const Vec3& position_m, const Twist& twist);
  /// Corners that carry as well as those that a body touched with, for the decision about rest.
  void note_near_corners(std::uint32_t body, Tick tick);
  /// Calls found(touch) for all corners that touch the same face as a touch was at, or are so near.
  void corners_like(std::uint32_t body, const TouchRecord& touch, Tick tick, double near_m,
                    const std::function<void(const TouchRecord&)>& found);
  struct RestTouch;
  void find_rest_touches(std::uint32_t body, std::vector<RestTouch>& found,
                         std::optional<SceneError>& error);
  SceneError error_of_rest(std::uint32_t body, double missing, bool holds_if_rough,
                           const std::vector<RestTouch>& touches) const;
  std::optional<SceneError> lay_down_structure(std::span<const std::uint32_t> members,
                                               const std::vector<RestTouch>& touches);
  // Of bodies that stay on planes (world_planes.cpp).
  struct PlaneSupports {
    std::array<PlaneSupport, k_plane_supports_max> all;
    std::size_t count = 0;
    double lowest_m = 0;  ///< of any, above what is flat; at most 0
  };
  /// A plane, or a face of a static polyhedron or triangle.
  Flat flat_of(std::uint32_t index, std::uint32_t face) const;
  /// Which face has a normal; of a plane 0.
  std::optional<std::uint32_t> face_met(std::uint32_t index, const Vec3& normal) const;
  PlaneSupports supports_on(std::uint32_t body, std::uint32_t index, const Flat& flat, Tick tick);
  /// How a body with such a twist stays on what it touches, if it does.
  std::optional<PlaneStay> stay_of(std::uint32_t body, std::uint32_t index, std::uint32_t face,
                                   const Twist& twist, Tick tick);
  /// What carries a body that stays on a plane, for the decision about rest.
  void note_plane_supports(std::uint32_t body, Tick tick);
  /// A body that has just begun a segment may keep its place.
  void note_place(std::uint32_t body);
  /// Counts a collision of a body; how many it had at this tick.
  std::uint32_t count_at(std::uint32_t body, Tick tick) {
    const std::uint32_t count = collided_[body].add(tick);
    if (collided_[body].is_too_much()) [[unlikely]]
      note_too_much(body, tick);
    return count;
  }
  void note_too_much(std::uint32_t body, Tick tick);
  /// Of bodies of several round parts, as the world is made: those of one shape share its hull.
  using HullOfShape = std::vector<std::pair<const Compound*, std::uint32_t>>;
  std::uint32_t hull_index(const Compound& compound, HullOfShape& known);
  /// Whether the hulls of two bodies of several parts are apart; `examined` is then the look's
  /// result for each pair of parts.
  bool hulls_apart(std::uint32_t a, std::uint32_t b, Tick tick, double touch_m,
                   SeparationCache& cache, Examined& examined);
  /// Until when two bodies don't collide again, unless they come faster or closer (tolerances.h).
  Refractory refractory_of_parts(std::uint32_t a, std::uint32_t b);
  Refractory refractory_of_spheres(std::uint32_t a, std::uint32_t b) const;
  Prediction predict_spheres(std::uint32_t a, std::uint32_t b, Tick from) const;
  RigidImpactBody rigid_body(std::uint32_t body, Tick tick);
  PieceContact contact_at(std::uint32_t a, std::uint32_t b, const EventKey& event);
  /// A body has touched a surface, at an arm from its centre.
  void note_surface(std::uint32_t body, std::uint32_t index, Tick tick, const Vec3& centre_m,
                    const Vec3& arm_m);
  PieceContact contact_with_static(std::uint32_t index, std::uint32_t body, std::uint32_t part,
                                   Tick tick);
  bool is_surface(std::uint32_t body, std::uint32_t index) const {
    return !constants_[body].is_sphere && index >= statics_.piece_count();
  }
  MetSurface& surface(std::uint32_t index) const {
    return surfaces_[index - statics_.piece_count()];
  }
  const BoxLattice& lattice_on(std::uint32_t index, std::uint32_t body, std::uint32_t part) const {
    return surface(index).lattices[constants_[body].first_part + part];
  }
  /// How a body bounces off static geometry, at a contact.
  SurfaceLaw law_of_static(std::uint32_t body, std::uint32_t index, const Vec3& point_m) const;
  PieceContact static_contact_at(std::uint32_t body, std::uint32_t index, const EventKey& event);
  /// As contact_motion asks for a sphere.
  RoundBody round_body(std::uint32_t body) const {
    return physics::round_body(constants_[body].reach_m, constants_[body].inertia, scene_.slow);
  }
  bool is_resting(std::uint32_t body) const { return segments_[body].mode == MotionMode::resting; }
  /// What the search found that came to the event, if that was the last one to find a collision.
  const PieceContact* found_contact(std::uint32_t a, std::uint32_t b, const EventKey& event) const {
    const bool same = found_.tick == event.tick && found_.a == a && found_.b == b &&
                      found_.feature == event.feature;
    return same ? &found_.contact : nullptr;
  }
  template <bool k_fresh>
  bool predict_flight_from(std::uint32_t body, std::span<PairEdge> edges,
                           std::span<const std::uint32_t> changes, Tick now) const;
  /// collide for two spheres in flight that don't turn, in a world of plain spheres: the same
  /// bits from less memory.
  void collide_plain(std::uint32_t a, std::uint32_t b, const EventKey& event);
  void note_failure(SceneError::Kind kind, const std::string& what, std::uint32_t body, Tick tick);
  void note_search_gave_up(std::uint32_t body, Tick tick);

  // Keeping and replaying histories (world_replay.cpp).
  void append_to_history(const EventKey& event);
  void stop_history();
  void note_touch(std::uint32_t body, const TouchRecord& touch, bool slowly) {
    resting_.touched(body, touch, slowly);
    if (history_builder_) history_builder_->touches(body, touch, slowly);
  }
  /// What a body knows is about to change, or has, in more than what it touches.
  void note_contact_state(std::uint32_t body) {
    if (history_builder_) history_builder_->has_contact_state(body);
  }
  void find_quiet_until();
  void restore(const HistoryEvent& event);
  void restore_surface(const HistoryEvent& event);
  void set_replayed(std::uint32_t body);

  Scene scene_;
  StaticGeometry statics_;
  mutable std::vector<MetSurface> surfaces_;  ///< they keep what they were asked
  std::vector<SurfaceTouch> surface_touches_;
  NearVector<Flight> flights_;
  NearVector<Segment> segments_;
  NearVector<BodyConstants> constants_;
  std::vector<std::uint8_t> started_;
  std::vector<Turning> turning_;
  std::vector<Supports> supports_;  ///< by body; empty if no body can stay on anything
  struct AtRest {
    std::vector<TouchRecord> touches;
    std::vector<std::uint32_t> supporters;
  };
  std::vector<AtRest> at_rest_;     ///< by body, as they start; empty if none starts at rest
  TickCount alone_for_ = 0;         ///< a sphere stays only if it has met no body for so long
  std::vector<PointPiece> points_;  ///< of spheres
  std::vector<ConvexView> parts_;   ///< of all bodies
  std::vector<ConvexView> hulls_;   ///< of bodies that have one
  std::vector<std::unique_ptr<const RoundPiece>> made_hulls_;
  /// The last look at two hulls: each pair of parts asks for it.
  struct HullLook {
    Tick tick{-1};
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    double touch_m = 0;
    bool apart = false;
    Examined examined;
  };
  HullLook hull_look_;
  PieceSearches searches_;
  Resting resting_;
  RecentContacts recent_;
  NearPlaces places_;
  std::vector<std::uint32_t> changed_;
  /// How two parts collide that a search found to do so: the collision mostly comes next. Void
  /// once a body begins a segment.
  struct Found {
    Tick tick{-1};
    std::uint32_t a = 0;
    std::uint32_t b = 0;  ///< or static geometry, marked with k_static
    std::uint32_t feature = 0;
    PieceContact contact;
  };
  Found found_;
  std::vector<CollisionCount> collided_;  ///< by body
  Recording recording_;
  std::unique_ptr<HistoryBuilder> history_builder_;
  std::size_t history_recorded_ = 0;  ///< events of the history whose segments are in the recording
  std::unique_ptr<Replay> replay_;
  std::vector<std::uint8_t> replayed_;  ///< by body
  std::uint32_t replayed_count_ = 0;
  std::vector<std::uint32_t> gone_live_;
  std::optional<SceneError> failure_;
  /// What predict_flight needs of the axes: beyond `half_m` the nearest image is another; it is at
  /// one period if the distance is within `sure_m` of `middle_m`.
  struct Images {
    Lanes period_m{};
    Lanes half_m = Lanes::all(std::numeric_limits<double>::infinity());
    Lanes middle_m{};
    Lanes sure_m{};
  };
  Images images_;
  bool record_ = true;
  bool records_without_history_ = true;
  bool periodic_ = false;
  bool has_statics_ = false;
  bool has_modes_ = false;      ///< bodies that may have mode events
  bool only_spheres_ = true;    ///< moving
  bool plain_spheres_ = false;  ///< of one material without friction; nothing rests, slow or not
  /// Of each sphere: whether it turns. The fast way past a segment, which then needs no look.
  std::vector<std::uint8_t> turns_;
};

}  // namespace sleight::physics
