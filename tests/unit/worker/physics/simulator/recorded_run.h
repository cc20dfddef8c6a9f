// Runs scenes and reads states from their recordings without the simulator's functions.
//
// Thread safety: values and pure functions.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "worker/physics/motion/rotation_track.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics::testing {

struct RecordedRun {
  Scene scene;
  Recording recording;
  Counts counts;
  std::string error;
};

/// A floor for bodies of size `size_m`. The floor is level or descends towards x.
inline Scene floor_scene(double size_m, const SurfaceLaw& law, double slope_rad = 0) {
  constexpr double k_gravity_mps2 = 9.81;
  Scene scene;
  scene.gravity_mps2 = k_gravity_mps2 * Vec3(std::sin(slope_rad), 0, -std::cos(slope_rad));
  scene.contacts = ContactTable(1, law);
  scene.slow = slow_contacts_of(size_m, k_gravity_mps2);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  return scene;
}

inline RecordedRun recorded(const Scene& scene, double duration_s) {
  auto started = Simulation::start(scene, {});
  if (!started) return {scene, {}, {}, started.error().message};
  Simulation simulation = std::move(started).value();
  const auto error = simulation.run_until(Tick{} + ticks_after(duration_s));
  return {scene, simulation.recording(), simulation.counts(), error ? error->message : ""};
}

inline Vec3 place_at(const Segment& segment, Tick tick) {
  const FreeFlight& flight = segment.flight;
  const double s = static_cast<double>(tick.value - flight.begin.value) * 0x1p-30;
  return flight.position_m + s * flight.velocity_mps + (0.5 * s * s) * flight.acceleration_mps2;
}

/// Orientation of a body with constant angular acceleration. Computed in many small steps.
inline Quat turn_in_contact(const Segment& segment, double s) {
  constexpr int k_steps = 20'000;
  const double h = s / k_steps;
  Quat turn = segment.flight.orientation;
  for (int i = 0; i < k_steps; ++i) {
    const Vec3 w = segment.flight.angular_velocity_radps +
                   ((i + 0.5) * h) * segment.angular_acceleration_radps2;
    const Vec3 half = 0.5 * h * w;
    turn = math::normalized(math::composed(Quat(1, half.x(), half.y(), half.z()), turn));
  }
  return turn;
}

/// Orientation of a body with constant angular velocity. Computed with the C library's sine. Other
/// inertias use the motion library, which has its own tests.
inline Quat turn_at(const Segment& segment, const Inertia& inertia, Tick tick) {
  const FreeFlight& flight = segment.flight;
  if (segment.mode == MotionMode::resting) return flight.orientation;
  const double s = static_cast<double>(tick.value - flight.begin.value) * 0x1p-30;
  if (in_contact(segment)) return turn_in_contact(segment, s);
  if (inertia.symmetry != InertiaSymmetry::spherical) return orientation_at(flight, inertia, tick);
  const Vec3& w = flight.angular_velocity_radps;
  const double rate = std::sqrt(w.x() * w.x() + w.y() * w.y() + w.z() * w.z());
  if (rate == 0) return flight.orientation;
  const double half = 0.5 * rate * s;
  const double share = std::sin(half) / rate;
  return math::composed(Quat(std::cos(half), share * w.x(), share * w.y(), share * w.z()),
                        flight.orientation);
}

/// Twist in the world frame.
inline Twist twist_in(const Segment& segment, const Inertia& inertia, Tick tick) {
  const FreeFlight& flight = segment.flight;
  const double s = static_cast<double>(tick.value - flight.begin.value) * 0x1p-30;
  Twist twist{.velocity_mps = flight.velocity_mps + s * flight.acceleration_mps2,
              .angular_velocity_radps =
                  flight.angular_velocity_radps + s * segment.angular_acceleration_radps2};
  if (segment.mode == MotionMode::free && inertia.symmetry != InertiaSymmetry::spherical)
    twist.angular_velocity_radps = angular_velocity_at(flight, inertia, tick);
  return twist;
}

/// Kinetic energy, including rotation.
inline double energy_of_motion_j(const Inertia& inertia, const Quat& orientation,
                                 const Twist& twist) {
  const Vec3 w = math::rotated(math::inverse(orientation), twist.angular_velocity_radps);
  const Vec3& v = twist.velocity_mps;
  const Vec3& moments = inertia.principal_kgm2;
  return 0.5 * (inertia.mass_kg * math::dot(v, v) + moments.x() * w.x() * w.x() +
                moments.y() * w.y() * w.y() + moments.z() * w.z() * w.z());
}

inline double energy_j(const Scene& scene, std::uint32_t body, const Segment& segment, Tick tick) {
  const Inertia& inertia = scene.bodies[body].inertia;
  return energy_of_motion_j(inertia, turn_at(segment, inertia, tick),
                            twist_in(segment, inertia, tick)) -
         inertia.mass_kg * math::dot(scene.gravity_mps2, place_at(segment, tick));
}

}  // namespace sleight::physics::testing
