#include "worker/worlds/user_scene/constraints.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "common/math/elementary.h"
#include "common/math/rotation.h"

namespace sleight::worlds::user_scene {
namespace {

bool is_place(const Constraint& constraint) {
  return constraint.asks == Asks::region || constraint.asks == Asks::place;
}

}  // namespace

Region box_of(const physics::Shape& shape, const Pose& pose) {
  Region box;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 direction = math::rotated(math::inverse(pose.orientation), Vec3::Unit(axis));
    box.low_m[axis] = pose.position_m[axis] - support_m(shape, -direction);
    box.high_m[axis] = pose.position_m[axis] + support_m(shape, direction);
  }
  return box;
}

Region box_of(const BuiltScene& built, std::uint32_t object) {
  const Object& one = built.objects[object];
  if (object < built.bodies)
    return box_of(built.scene.bodies[object].shape, built.scene.bodies[object].start.pose);
  Region box{.low_m = Region{}.high_m, .high_m = Region{}.low_m};
  const auto add = [&](const Vec3& point_m) {
    box.low_m = box.low_m.cwiseMin(point_m);
    box.high_m = box.high_m.cwiseMax(point_m);
  };
  if (one.kind == ObjectKind::mesh)
    std::ranges::for_each(built.scene.meshes[one.first].mesh->vertices_m(), add);
  for (std::uint32_t i = 0; one.kind == ObjectKind::convex && i < one.count; ++i)
    std::ranges::for_each(built.scene.convexes[one.first + i].polyhedron->vertices_m(), add);
  return box;
}

double outside_m(const Region& region, const Region& box) {
  const Vec3 beyond_m =
      (box.high_m - region.high_m).cwiseMax(region.low_m - box.low_m).cwiseMax(Vec3::Zero());
  return math::norm(beyond_m);
}

DistanceUnit unit_of(const Constraint& constraint) {
  if (is_place(constraint)) return {"mm", 1e-3};
  if (constraint.asks == Asks::count) return {"bodies", 1};
  if (constraint.asks >= Asks::event) return {"s", 1};
  return {"degrees", std::numbers::pi / 180};
}

double log_constraint_of(const Constraint& constraint, double distance) {
  if (constraint.asks == Asks::count) return -constraint.log_lambda * distance;
  const double z = distance / constraint.sigma;
  return z <= 3 ? -0.5 * z * z : -(3 * z - 4.5);
}

std::string contradiction_of(const Constraint& a, const Constraint& b) {
  if (a.bodies.size() != 1 || a.bodies != b.bodies) return {};
  const double slack = (a.tolerance + b.tolerance) * (1 + 1e-9) + 1e-12;
  if (a.looks_at_hits() && b.looks_at_hits() && a.hits == b.hits &&
      a.at_least_mps == b.at_least_mps) {
    if (a.asks != b.asks) return "the one asks for a hit that the other forbids";
    if (a.nth != b.nth || a.times_s.size() != 1 || b.times_s.size() != 1) return {};
    const double apart_s = std::abs(a.times_s.front() - b.times_s.front());
    if (apart_s <= slack) return {};
    return fmt::format("both ask for hit number {}, at times that are {:.4g} s apart", a.nth,
                       apart_s);
  }
  if (a.at_s != b.at_s) return {};
  if (is_place(a) && is_place(b)) {
    const Vec3 apart_m = (a.region.low_m - b.region.high_m)
                             .cwiseMax(b.region.low_m - a.region.high_m)
                             .cwiseMax(Vec3::Zero());
    const double least_m = math::norm(apart_m);
    if (least_m <= slack) return {};
    return fmt::format("the places are {:.4g} mm apart, but the tolerances add up to {:.4g} mm",
                       1e3 * least_m, 1e3 * slack);
  }
  if (a.asks == Asks::face && b.asks == Asks::face) {
    const double between_rad =
        math::atan2(math::norm(math::cross(a.axis, b.axis)), math::dot(a.axis, b.axis));
    if (between_rad > slack)
      return fmt::format("the two directions are {:.4g} degrees apart",
                         180 / std::numbers::pi * between_rad);
  }
  const bool tilts = (a.asks == Asks::topples && b.asks == Asks::stands) ||
                     (a.asks == Asks::stands && b.asks == Asks::topples);
  if (tilts && slack < k_topples_rad - k_stands_rad) return "a body can't stand and topple";
  return {};
}

}  // namespace sleight::worlds::user_scene
