// Computes which static features carry a sphere in lasting contact, and when the contact ends.
// Doesn't use a world. contact_events.h has the rules.
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

/// Returns the tick that is `span_s` after `tick`, but at least the next tick. If the result would
/// be after the last tick of a simulation, returns k_never.
Tick tick_after(Tick tick, double span_s);

/// Height of the slowest bounces.
double bounce_m(const SlowContacts& slow, const Vec3& gravity_mps2);

/// Returns the tick at which a point on a plane reaches an area of different friction. If it
/// reaches none before `end`, returns k_never.
Tick meets_border(const FrictionMap& map, const MapPath& path, Tick from, Tick end);

/// Converts a sphere for contact_motion.h. REQUIRES: the inertia of a ball.
RoundBody round_body(double radius_m, const Inertia& inertia, const SlowContacts& slow);

/// Returns an upper bound for the speed of a ball's fastest point.
inline double fastest_point_mps(double radius_m, const Twist& twist) {
  const double turning = radius_m * math::norm(twist.angular_velocity_radps);
  return math::norm(twist.velocity_mps) + turning;
}

/// Returns the first tick at which a ball in contact is slow enough for rest. If the segment ends
/// earlier, returns k_never.
Tick slow_from(const Segment& segment, double radius_m, const Inertia& inertia,
               const SlowContacts& slow, Tick end);

struct Stay {
  static constexpr FeatureId k_none{UINT32_MAX};
  std::uint32_t subset = 0;  ///< bit i: the sphere stays on the i-th feature
  Segment segment;
  Tick end = k_never;            ///< the stay must be recomputed then
  FeatureId leaves = k_none;     ///< feature that the sphere leaves at `end`, if any
  Vec3 half_way = Vec3::Zero();  ///< nonzero for a piece over an edge (edge_motion.h)
};

/// Up to three features that a sphere may stay on, and the sphere's contacts with these features.
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

/// Returns how a sphere stays on features from the start of `now` on. `now` is the sphere's free
/// flight if no feature carries it. The sphere stays on the largest set of features that all carry
/// it while it presses on no other feature. Empty: no feature carries it. On a single edge, the
/// sphere moves piece by piece (edge_motion.h). If no piece is possible, it moves straight on for a
/// few micrometres.
std::optional<Stay> stay_on(const RoundBody& round, const MayStayOn& on, const FreeFlight& now,
                            const ContactScene& scene);

/// The next motion of a sphere that stayed on some contacts and has just lost its bounce on a new
/// one.
struct Caught {
  std::size_t count = 1;  ///< the sphere may stay on the first `count` contacts
  Twist twist{};
  /// Twist if no contact carries the sphere. For example, friction may pull the sphere onto a
  /// feature on which it doesn't press. The sphere then hops off the new feature. Without the hop,
  /// the old feature would throw the sphere back again and again.
  Twist otherwise{};
};

/// The first contact is the new one. If the sphere moves fast across the other contacts, it rolls
/// up the new feature; otherwise it may stay on all contacts. REQUIRES: one to three contacts; the
/// sphere doesn't approach the first.
Caught caught_by(const RoundBody& round, std::span<const LastingContact> contacts,
                 const Twist& twist, const SlowContacts& slow);

/// Returns a sphere's twist during a piece of motion over an edge. The edge's normal is `half_way`.
/// The result is the segment's twist, corrected for the work that the load has done (without_lift).
Twist twist_over_edge(const RoundBody& round, const Segment& segment, const Vec3& half_way,
                      const Vec3& gravity_mps2, Tick tick);

/// Returns whether a sphere that stands still on these contacts stays at rest.
bool stands_on(const RoundBody& round, std::span<const LastingContact> contacts,
               const Vec3& gravity_mps2);

}  // namespace sleight::physics
