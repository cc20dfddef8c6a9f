// How a user's scene must end: constraints, read from a simulation.
//
// A constraint measures a distance d >= 0 in its unit:
//
//   region   from a body's origin, or from all of the body, to a box; m
//   place    from a body's origin to a point; m
//   face     angle between an axis of a body and the upward direction; rad
//   topples  angle by which the axis that pointed up at the start is less than 45 degrees off; rad
//   stands   angle by which that axis is more than 5 degrees off; rad
//   count    number of a group's bodies that are missing in a region
//   event    time between a hit and its wanted time; s
//   order    time by which events come in the wrong order; s
//   never    time between a hit and the end of the simulation; s
//
// With sigma, the constraint adds log p_c = -z^2 / 2 for z = d / sigma <= 3, and -(3 z - 4.5)
// beyond. So a wide miss doesn't make p_c tiny. `count` adds -log_lambda d. A constraint is met if
// d <= tolerance. A constraint without a time looks at the end, and is met only if its body rests.
//
// A hit that doesn't come within window_s of its time has d = window_s + sigma gap / near_m. Here
// `gap` is the least gap in this window between the two bodies: the distance from the centre of the
// one to the box of the other, less the reach of the one. A body that doesn't take part has
// z = k_absent_z.
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "worker/worlds/user_scene/build.h"

namespace sleight::worlds::user_scene {

enum class Asks : std::uint8_t { region, place, face, topples, stands, count, event, order, never };

inline constexpr double k_absent_z = 30;
inline constexpr double k_topples_rad = std::numbers::pi / 4;
inline constexpr double k_stands_rad = std::numbers::pi / 36;

/// An axis-aligned box. For a place, both corners are equal, except on an axis of no interest.
struct Region {
  Vec3 low_m = Vec3::Constant(-std::numeric_limits<double>::infinity());
  Vec3 high_m = Vec3::Constant(std::numeric_limits<double>::infinity());
};

struct Constraint {
  std::string name;
  Asks asks = Asks::region;
  /// Objects (BuiltScene::objects). If there are several, `count` counts them; otherwise the one
  /// with the least d counts.
  std::vector<std::uint32_t> bodies{};
  std::optional<double> at_s{};  ///< region to count: time; empty: at the end, at rest
  Region region{};
  bool whole = false;
  Vec3 axis = Vec3::UnitZ();   ///< face: in the shape's frame
  std::uint32_t at_least = 0;  ///< count
  double log_lambda = 0;       ///< count
  // Hits: the `nth` hit of a body and one of `hits` with at least this speed of approach.
  std::vector<std::uint32_t> hits{};  ///< objects
  std::uint32_t nth = 1;
  double at_least_mps = 0;
  /// Wanted times of an event, in ascending order: one of them, or the range `from_s` to `to_s`.
  std::vector<double> times_s{};
  double from_s = 0;
  double to_s = std::numeric_limits<double>::infinity();
  double window_s = 0.25;
  double near_m = 0.01;
  std::vector<std::uint32_t> events{};  ///< order: indices of constraints

  double sigma = 1;
  double tolerance = 0;
  std::uint32_t line = 0;  ///< in the request, for errors

  bool looks_at_hits() const { return asks == Asks::event || asks == Asks::never; }
  bool looks_at_rest() const { return asks <= Asks::count && !at_s; }
};

/// Returns the box around a shape whose body's frame has this pose.
Region box_of(const physics::Shape& shape, const Pose& pose);
/// Returns the box around an object at its start. REQUIRES: it is no plane.
Region box_of(const BuiltScene& built, std::uint32_t object);
/// Returns how far a box reaches out of a region; 0 if it is inside.
double outside_m(const Region& region, const Region& box);
/// Returns the distance of a point from a region; 0 inside.
inline double outside_m(const Region& region, const Vec3& point_m) {
  return outside_m(region, Region{.low_m = point_m, .high_m = point_m});
}

/// The unit of a constraint's distances for people: its name, and its size in SI units.
struct DistanceUnit {
  const char* name;
  double scale;
};
DistanceUnit unit_of(const Constraint& constraint);

/// Returns log p_c of a distance.
double log_constraint_of(const Constraint& constraint, double distance);

/// Returns why no simulation meets both constraints, or an empty text.
std::string contradiction_of(const Constraint& a, const Constraint& b);

}  // namespace sleight::worlds::user_scene
