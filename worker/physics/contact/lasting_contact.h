// Spheres that stay on static geometry, as far as it needs no world: which faces carry a sphere,
// and when its contact ends. contact_events.h says what stays and why.
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

/// A tick so much later, at least the next one; k_never if that is beyond a simulation's end.
Tick tick_after(Tick tick, double span_s);

/// The height of the slowest bounces.
double bounce_m(const SlowContacts& slow, const Vec3& gravity_mps2);

/// When what moves on a plane comes to where friction is another one; k_never if not before an end.
Tick meets_border(const FrictionMap& map, const MapPath& path, Tick from, Tick end);

/// A sphere as contact_motion asks for it. REQUIRES: the inertia of a ball.
RoundBody round_body(double radius_m, const Inertia& inertia, const SlowContacts& slow);

/// Speed of a ball's fastest point, at most.
inline double fastest_point_mps(double radius_m, const Twist& twist) {
  const double turning = radius_m * math::norm(twist.angular_velocity_radps);
  return math::norm(twist.velocity_mps) + turning;
}

/// The first tick from which on a ball in contact is slower than it must be for rest; k_never if it
/// isn't until its segment ends.
Tick slow_from(const Segment& segment, double radius_m, const Inertia& inertia,
               const SlowContacts& slow, Tick end);

/// How a sphere stays on some of up to three features.
struct Stay {
  static constexpr FeatureId k_none{UINT32_MAX};
  std::uint32_t subset = 0;  ///< bit i: of the features, it stays on the i-th
  Segment segment;
  Tick end = k_never;            ///< then all this is to be asked for again
  FeatureId leaves = k_none;     ///< the feature that the sphere leaves then, if any
  Vec3 half_way = Vec3::Zero();  ///< over an edge, piece by piece: of edge_motion.h; else 0
};

/// The features that a sphere may stay on, three at most, and its contacts with them.
struct MayStayOn {
  std::span<const FeatureId> features;
  std::span<const LastingContact> contacts;
  bool rolled = false;  ///< it has rolled on all of them up to now
};

/// What a scene says of contacts that last.
struct ContactScene {
  const StaticGeometry& statics;
  const SlowContacts& slow;
  const Vec3& gravity_mps2;
};

/// What begins at a tick with a twist: it stays on the most features that all carry it, while it
/// does not press on the others; nothing if none carries it. Over an edge alone it moves piece by
/// piece (edge_motion.h). What it can't do in pieces it begins straight on, for some micrometres.
/// `now`: the sphere's flight from this tick on, if it were free.
std::optional<Stay> stay_on(const RoundBody& round, const MayStayOn& on, const FreeFlight& now,
                            const ContactScene& scene);

/// How a sphere goes on that has just lost its bounce on the first of some contacts, the others of
/// which it stayed on.
struct Caught {
  std::size_t count = 1;  ///< of the contacts, the first ones are those that it may stay on
  Twist twist{};
  /// If nothing carries it, as where friction pulls it on to what it doesn't press on: it hops off
  /// the new one, else it would come back from the old one at once, again and again.
  Twist otherwise{};
};

/// On what it stayed before it stays as well, unless it is fast across that: then it rolls up the
/// new one. REQUIRES: one to three contacts; it doesn't approach the first one.
Caught caught_by(const RoundBody& round, std::span<const LastingContact> contacts,
                 const Twist& twist, const SlowContacts& slow);

/// A sphere's twist over an edge, of a stay with such a half_way: what the segment says of its
/// motion, without what its load has lifted it by.
Twist twist_over_edge(const RoundBody& round, const Segment& segment, const Vec3& half_way,
                      const Vec3& gravity_mps2, Tick tick);

/// Whether a sphere in contact would not accelerate if it stood still.
bool stands_on(const RoundBody& round, std::span<const LastingContact> contacts,
               const Vec3& gravity_mps2);

}  // namespace sleight::physics
