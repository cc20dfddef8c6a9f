// Spheres that stay on static geometry, as far as it needs no world: which faces carry a sphere,
// and when its contact ends. world_modes.cpp says what stays and why.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "worker/physics/response/contact_motion.h"
#include "worker/physics/simulator/scene.h"
#include "worker/physics/simulator/segment.h"
#include "worker/physics/simulator/sphere_search.h"
#include "worker/physics/simulator/static_geometry.h"

namespace sleight::physics {

/// A sphere that has met another body stays on nothing for so many of its slowest bounces.
inline constexpr double k_bounces_alone = 4;
/// A body that collides often enough in so many of its slowest bounces is jammed.
inline constexpr double k_jam_bounces = 5;
/// Over an edge or a vertex it hops if it is faster than so many times its slowest bounces.
inline constexpr double k_edge_speeds = 16;
/// What a sphere that rolls leaves an edge or a resting body with, as a part of the separation
/// speed: less than other bounces have, as it is paid from its rolling.
inline constexpr double k_hop_share = 0.25;

/// A tick so much later, at least the next one; k_never if that is beyond a simulation's end.
Tick tick_after(Tick tick, double span_s);

/// A sphere as contact_motion asks for it. REQUIRES: the inertia of a ball.
RoundBody round_body(double radius_m, const Inertia& inertia, const SlowContacts& slow);

/// Speed of a ball's fastest point, at most.
inline double fastest_point_mps(double radius_m, const Twist& twist) {
  const double turning = radius_m * math::norm(twist.angular_velocity_radps);
  return math::norm(twist.velocity_mps) + turning;
}

/// When the centre leaves the region of a face, by the segment's parabola.
Tick leaves_region(const FreeFlight& flight, std::span<const RegionSide> sides);

/// When a sphere that goes straight on from an edge or a vertex has left that.
Tick leaves_edge(const FreeFlight& flight, double radius_m, const SlowContacts& slow,
                 const Vec3& gravity_mps2);

/// Until when a sphere stays as it does on some features, and the one whose region its centre
/// leaves then, if that ends it.
struct StayEnd {
  static constexpr std::uint32_t k_none = UINT32_MAX;
  Tick tick = k_never;
  std::uint32_t leaves = k_none;
};
/// `lasts_s`: of the motion, by itself.
StayEnd stay_end(const FreeFlight& flight, double lasts_s, std::span<const std::uint32_t> features,
                 const StaticGeometry& statics, double radius_m, const SlowContacts& slow,
                 const Vec3& gravity_mps2);

/// The first tick from which on a ball in contact is slower than it must be for rest; k_never if it
/// isn't until its segment ends.
Tick slow_from(const Segment& segment, double radius_m, const Inertia& inertia,
               const SlowContacts& slow, Tick end);

/// Some of up to three contacts, as bits, and how a sphere moves that stays on them.
struct Carried {
  std::uint32_t subset = 0;
  ContactMotion motion{};
};

/// The most contacts that all carry a sphere, while it does not press on the others; nothing if
/// none does. REQUIRES: at most three contacts.
std::optional<Carried> carried_by(const RoundBody& round, std::span<const LastingContact> contacts,
                                  const Twist& twist, const Vec3& gravity_mps2);

/// Whether a sphere in contact would not accelerate if it stood still.
bool stands_on(const RoundBody& round, std::span<const LastingContact> contacts,
               const Vec3& gravity_mps2);

}  // namespace sleight::physics
