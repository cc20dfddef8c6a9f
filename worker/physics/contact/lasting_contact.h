// Lasting contact of spheres with static geometry, without access to a world: which features carry
// a sphere, and when the contact ends. contact_events.h has the rules.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/motion/segment.h"
#include "worker/physics/response/contact_motion.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/scene/static_geometry.h"

namespace sleight::physics {

/// Returns the tick after a span, and at least the next tick. Returns k_never if a simulation ends
/// before that tick.
Tick tick_after(Tick tick, double span_s);

/// Height of the slowest bounces.
double bounce_m(const SlowContacts& slow, const Vec3& gravity_mps2);

/// Tick at which a point that moves on a plane reaches an area of different friction, or k_never if
/// the point reaches none before `end`.
Tick meets_border(const FrictionMap& map, const MapPath& path, Tick from, Tick end);

/// Converts a sphere for contact_motion.h. REQUIRES: the inertia of a ball.
RoundBody round_body(double radius_m, const Inertia& inertia, const SlowContacts& slow);

/// Upper bound for the speed of a ball's fastest point.
inline double fastest_point_mps(double radius_m, const Twist& twist) {
  const double turning = radius_m * math::norm(twist.angular_velocity_radps);
  return math::norm(twist.velocity_mps) + turning;
}

/// First tick from which a ball in contact is slow enough for rest, or k_never if its segment ends
/// before the ball is.
Tick slow_from(const Segment& segment, double radius_m, const Inertia& inertia,
               const SlowContacts& slow, Tick end);

/// How a sphere stays on up to three features.
struct Stay {
  static constexpr FeatureId k_none{UINT32_MAX};
  std::uint32_t subset = 0;  ///< bit i: the sphere stays on the i-th feature
  Segment segment;
  Tick end = k_never;            ///< the stay must be recomputed then
  FeatureId leaves = k_none;     ///< feature that the sphere leaves at `end`, if any
  Vec3 half_way = Vec3::Zero();  ///< nonzero for a piece over an edge (edge_motion.h)
};

/// The features that a sphere may stay on, three at most, and the contacts with them.
struct MayStayOn {
  std::span<const FeatureId> features;
  std::span<const LastingContact> contacts;
  bool rolled = false;  ///< the sphere has rolled on all of them so far
};

struct ContactScene {
  const StaticGeometry& statics;
  const SlowContacts& slow;
  const Vec3& gravity_mps2;
};

/// Returns how a sphere stays on features from a given tick on. The sphere stays on the largest set
/// of features that all carry it while it doesn't press on the other features. Empty: no feature
/// carries it. On a single edge the sphere moves piece by piece (edge_motion.h), or straight on for
/// a few micrometres if no piece is possible. `now`: the sphere's free flight from this tick.
std::optional<Stay> stay_on(const RoundBody& round, const MayStayOn& on, const FreeFlight& now,
                            const ContactScene& scene);

/// The next motion of a sphere that has just lost its bounce on the first of some contacts, while
/// it stayed on the other contacts.
struct Caught {
  std::size_t count = 1;  ///< the sphere may stay on the first `count` contacts
  Twist twist{};
  /// Twist if no contact carries the sphere. For example, friction may pull it onto a feature that
  /// it doesn't press on. The sphere hops off the new feature; otherwise the old feature would
  /// throw the sphere back at once, again and again.
  Twist otherwise{};
};

/// Keeps the previous contacts too, unless the sphere moves fast across them; then the sphere rolls
/// up the new feature. REQUIRES: one to three contacts; the sphere doesn't approach the first.
Caught caught_by(const RoundBody& round, std::span<const LastingContact> contacts,
                 const Twist& twist, const SlowContacts& slow);

/// Returns a sphere's twist during a piece of motion over an edge with normal `half_way`. This is
/// the segment's twist, corrected for the work that the load has done (without_lift).
Twist twist_over_edge(const RoundBody& round, const Segment& segment, const Vec3& half_way,
                      const Vec3& gravity_mps2, Tick tick);

/// Whether a sphere that stands still on these contacts would remain at rest.
bool stands_on(const RoundBody& round, std::span<const LastingContact> contacts,
               const Vec3& gravity_mps2);

}  // namespace sleight::physics
