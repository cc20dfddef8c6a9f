// The bodies of a running simulation: their properties and their current motion.
//
// Invariants
//   1. A query's result depends only on the tick and the body's segment and supports, never on
//      earlier queries. Caches affect only speed.
//   2. A stored segment may be older than the body's Flight; segment() updates it.
// Thread safety: none.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "worker/physics/collision/convex_search.h"
#include "worker/physics/contact/contact_state.h"
#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/motion/motion_bounds.h"
#include "worker/physics/motion/rotation_track.h"
#include "worker/physics/response/contact_motion.h"
#include "worker/physics/response/rigid_impact.h"
#include "worker/physics/response/sphere_impact.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/shape/small_pieces.h"
#include "worker/physics/simulator/near_allocator.h"

namespace sleight::physics {

/// The data that predictions read for a sphere, in one cache line.
struct alignas(64) Flight {
  Vec3 position_m = Vec3::Zero();
  Vec3 velocity_mps = Vec3::Zero();
  Tick begin{};
  double radius_m = 0;  ///< radius of a sphere in free flight; 0: no closed form
};
static_assert(sizeof(Flight) == 64);

/// A body's constants. The constants that spheres need come first, in one cache line.
struct alignas(64) BodyConstants {
  SphereMass sphere_mass{};  ///< spheres only
  double reach_m = 0;        ///< radius of a sphere about the centre that contains the body
  MaterialId material{};
  bool is_sphere = true;
  bool has_round_parts = false;  ///< balls and rings (round_piece.h)
  bool fixed = false;            ///< never moves; its masses are infinite
  std::uint32_t first_part = 0;  ///< its convex parts in parts(); a sphere has one point
  std::uint32_t part_count = 1;
  /// Index in hulls_: the hull of the body's parts (hull_of()). k_no_hull: no hull.
  std::uint32_t hull = k_no_hull;
  static constexpr std::uint32_t k_no_hull = UINT32_MAX;
  CollisionGroup group{};
  Vec3 axis = Vec3::Zero();  ///< axis of a body of revolution, in its frame; otherwise 0
  Inertia inertia;
  RigidMass rigid_mass{};
};

/// Path of a body's centre (OnParabola in motion_bounds.h).
struct Path {
  Tick begin{};
  Vec3 position_m = Vec3::Zero();
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 acceleration_mps2 = Vec3::Zero();
};

class Bodies {
 public:
  /// Copies the scene.
  explicit Bodies(const Scene& scene);
  Bodies(const Bodies&) = delete;
  Bodies& operator=(const Bodies&) = delete;

  // Properties.
  const Scene& scene() const { return scene_; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(flights_.size()); }
  bool periodic() const { return periodic_; }
  bool only_spheres() const { return only_spheres_; }
  const BodyConstants& constants(BodyId body) const { return constants_[body]; }
  bool is_sphere(BodyId body) const { return constants_[body].is_sphere; }
  bool is_fixed(BodyId body) const { return !fixed_.empty() && constants_[body].fixed; }
  std::span<const BodyId> fixed() const { return fixed_; }
  /// Whether two bodies can collide. Two fixed bodies can't.
  bool may_meet(BodyId a, BodyId b) const {
    return all_meet_ || (!(is_fixed(a) && is_fixed(b)) &&
                         scene_.filter.meet(constants_[a].group, constants_[b].group));
  }
  /// Views of all bodies' convex parts; a body's parts begin at its first_part.
  std::span<const ConvexView> parts() const { return parts_; }
  std::string name(BodyId body) const;

  // Current motion.
  bool started(BodyId body) const { return started_[body] != 0; }
  MotionMode mode(BodyId body) const { return segments_[body].mode; }
  /// The reference is valid until the body's next segment begins.
  const Segment& segment(BodyId body) const {
    if (lags_) [[unlikely]]
      catch_up(body);
    return segments_[body];
  }
  const Flight& flight(BodyId body) const { return flights_[body]; }
  std::span<const Flight> flights() const { return flights_; }
  bool is_resting(BodyId body) const { return mode(body) == MotionMode::resting; }
  /// Whether a sphere's segment rotates.
  bool turns(BodyId body) const { return turns_[body] != 0; }
  /// Path of the body's segment. Reads the segment only if the body isn't a sphere in flight.
  Path path(BodyId body) const {
    const Flight& flight = flights_[body];
    return {.begin = flight.begin,
            .position_m = flight.position_m,
            .velocity_mps = flight.velocity_mps,
            .acceleration_mps2 = flight.radius_m > 0 ? scene_.gravity_mps2
                                                     : segments_[body].flight.acceleration_mps2};
  }
  double reach_m(BodyId body) const {
    const double radius_m = flights_[body].radius_m;
    return radius_m > 0 ? radius_m : constants_[body].reach_m;
  }
  /// Upper bound for the speed of the body's points relative to its centre. REQUIRES: not a sphere.
  double turning_speed_mps(BodyId body) const {
    return turning_speed_mps_max(turning_[body].bounds, constants_[body].reach_m);
  }
  /// Last tick for which the body's free rotation can be computed. REQUIRES: its inertia is
  /// general.
  Tick rotation_horizon(BodyId body) const { return turning_[body].track.horizon(); }

  // Supports.
  /// Whether any body may stay on static geometry.
  bool may_stay() const { return !supports_.empty(); }
  /// REQUIRES: may_stay().
  const Supports& supports(BodyId body) const { return supports_[body]; }
  bool stays_on_faces(BodyId body) const { return in_contact(segments_[body]); }

  // Candidates for new segments.
  Segment segment_of_start(const StartState& start, Tick tick) const;
  Segment segment_after(BodyId body, Tick tick, const Vec3& position_m, const Twist& twist);

  // Positions and motion at a tick.
  MovingPoint centre_at(BodyId body, Tick tick) const {
    const FreeFlight& flight = segment(body).flight;
    return {.position_m = physics::position_at(flight, tick),
            .velocity_mps = velocity_at(flight, tick),
            .acceleration_mps2 = flight.acceleration_mps2};
  }
  Quat orientation_at(BodyId body, Tick tick);
  Pose pose_at(BodyId body, Tick tick);
  Twist twist_at(BodyId body, Tick tick);
  Vec3 position_at(BodyId body, Tick tick) const {
    return physics::position_at(segment(body).flight, tick);
  }
  const MovingPiece& moving_at(BodyId body, Tick tick);
  MovingPiece part_at(BodyId body, std::uint32_t part, Tick tick);
  /// The hull of the body's parts (hull_of()), if the body has one.
  std::optional<MovingPiece> hull_at(BodyId body, Tick tick);
  RigidImpactBody rigid_body(BodyId body, Tick tick);
  /// Converts a sphere for contact_motion.h.
  RoundBody round_body(BodyId body) const {
    return physics::round_body(constants_[body].reach_m, constants_[body].inertia, scene_.slow);
  }
  /// Kinetic energy of all bodies that have started.
  double kinetic_energy_j(Tick tick);

  // Periodic worlds.
  /// Returns a shift by whole periods. Adding the shift to a vector gives the vector's shortest
  /// image.
  Vec3 to_nearest_image(const Vec3& between_m) const {
    Vec3 shift_m = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      const double period_m = scene_.period_m[static_cast<std::size_t>(i)];
      if (std::fabs(between_m[i]) <= 0.5 * period_m || period_m == 0) continue;
      shift_m[i] = -period_m * std::floor(between_m[i] / period_m + 0.5);
    }
    return shift_m;
  }
  /// Returns the vector from a's centre to the nearest image of b's centre.
  Vec3 between_at(BodyId a, BodyId b, Tick tick) const {
    const Vec3 between_m = position_at(b, tick) - position_at(a, tick);
    return periodic_ ? Vec3(between_m + to_nearest_image(between_m)) : between_m;
  }

  // fetch_flight() prefetches the data for a body's predictions, and fetch() the data for its next
  // collision.
  void fetch_flight(BodyId body) const { __builtin_prefetch(&flights_[body]); }
  void fetch(BodyId body) const {
    __builtin_prefetch(&flights_[body], 1);
    if (lags_) return;
    __builtin_prefetch(&segments_[body], 1);
    __builtin_prefetch(&segments_[body].flight.velocity_mps[2], 1);
    __builtin_prefetch(&constants_[body]);
  }

 private:
  // Only World may change bodies, because it then notifies its other parts (World::begin_segment).
  friend class World;
  void let_stay() { supports_.resize(size()); }
  Supports& supports_of(BodyId body) { return supports_[body]; }
  void stays_on_nothing(BodyId body) {
    if (supports_.empty()) return;
    supports_[body].count = 0;
    supports_[body].end = k_never;
  }
  void place(BodyId body, const Segment& segment);
  /// Begins a segment, without supports.
  void begin(BodyId body, const Segment& segment);
  void has_started(BodyId body) { started_[body] = 1; }
  /// Has the effect of begin() for a sphere that flies on without turning. To save memory traffic,
  /// fly_on() writes only the flight; segment() writes the segment later.
  void fly_on(BodyId body, Tick tick, const Vec3& position_m, const Vec3& velocity_mps) {
    lags_ = true;
    Flight& flight = flights_[body];
    flight.position_m = periodic_ ? wrapped_m(position_m) : position_m;
    flight.velocity_mps = velocity_mps;
    flight.begin = tick;
  }

  /// Further state of a body that isn't a sphere.
  struct Turning {
    RotationTrack track;
    RotationBounds bounds;
    Tick placed_at{-1};  ///< tick of `orientation` and `placed`
    Quat orientation = Quat::Identity();
    MovingPiece placed;  ///< without a view
  };

  /// Used while the table of hulls is built, because bodies with the same shape share a hull.
  using HullOfShape = std::vector<std::pair<const Compound*, std::uint32_t>>;
  std::uint32_t hull_index(const Compound& compound, HullOfShape& known);
  Vec3 wrapped_m(const Vec3& place_m) const;
  /// Updates a segment from its flight.
  void catch_up(BodyId body) const;

  Scene scene_;
  NearVector<Flight> flights_;
  mutable NearVector<Segment> segments_;
  NearVector<BodyConstants> constants_;
  std::vector<std::uint8_t> started_;
  std::vector<Turning> turning_;
  std::vector<Supports> supports_;
  std::vector<PointPiece> points_;  ///< of spheres
  std::vector<ConvexView> parts_;
  std::vector<ConvexView> hulls_;  ///< of bodies that have one
  std::vector<std::unique_ptr<const RoundPiece>> made_hulls_;
  std::vector<std::uint8_t> turns_;  ///< copy of a segment property that is faster to read
  std::vector<BodyId> fixed_;        ///< the fixed bodies, ascending
  bool all_meet_ = true;             ///< no body is fixed, and no pair is filtered
  bool periodic_ = false;
  bool only_spheres_ = true;
  bool lags_ = false;  ///< segments may be older than flights
};

}  // namespace sleight::physics
