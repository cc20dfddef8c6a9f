#include "tests/scenes/outline.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/math/angle.h"
#include "common/math/elementary.h"
#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "worker/physics/distance/placed_pose.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::scene_pictures {
namespace {

using physics::Pose;
using physics::Vec3;

constexpr int k_outline_corners = 60;

Vec3 in_world(const Pose& pose, const Vec3& local_m) {
  return pose.position_m + math::rotated(pose.orientation, local_m);
}

/// Returns a round piece's outline. For each direction of the picture, the outline has the piece's
/// furthest point.
Patch outline_of(const physics::RoundPiece& piece, const Pose& pose, const Camera& camera) {
  Patch patch;
  for (int i = 0; i < k_outline_corners; ++i) {
    const math::SinCos turn = math::sincos(math::k_two_pi * i / k_outline_corners);
    const Vec3 direction =
        math::rotated(math::inverse(pose.orientation), camera.seen_as(turn.cos, turn.sin));
    const Vec3 across = direction - math::dot(piece.axis(), direction) * piece.axis();
    const double length = math::norm(across);
    const Vec3 outwards = length > 1e-9 ? Vec3(across / length) : Vec3(Vec3::Zero());
    double most = -1e300;
    Vec3 furthest = Vec3::Zero();
    for (const physics::RoundFeature& feature : piece.features()) {
      const Vec3 point =
          feature.centre_m + feature.circle_m * outwards + feature.radius_m * direction;
      const double reach = math::dot(direction, point);
      if (reach <= most) continue;
      most = reach;
      furthest = point;
    }
    patch.outline_m.push_back(camera.on_picture_m(in_world(pose, furthest)));
  }
  const Vec3 axis = math::rotated(pose.orientation, piece.axis());
  // Use a middle tone. The tone changes as the body turns.
  patch.brightness = 0.65 + 0.25 * std::fabs(math::dot(axis, camera.towards()));
  return patch;
}

}  // namespace

Camera::Camera(double azimuth_rad, double elevation_rad) {
  const math::SinCos turn = math::sincos(azimuth_rad);
  const math::SinCos rise = math::sincos(elevation_rad);
  towards_ = Vec3(rise.cos * turn.cos, rise.cos * turn.sin, rise.sin);
  right_ = Vec3(-turn.sin, turn.cos, 0);
  up_ = math::cross(towards_, right_);
}

plot::Point Camera::on_picture_m(const Vec3& place_m) const {
  return {math::dot(right_, place_m), math::dot(up_, place_m)};
}

double Camera::nearness_m(const Vec3& place_m) const {
  return math::dot(towards_, place_m);
}

double brightness_of(const Vec3& normal) {
  const Vec3 light = math::normalized(Vec3(0.3, -0.5, 0.8));
  return 0.6 + 0.4 * std::max(-0.5, math::dot(normal, light));
}

std::vector<Patch> faces_of(const physics::ConvexView& view, const Pose& pose,
                            const Camera& camera) {
  std::vector<Patch> patches;
  for (std::size_t f = 0; f < view.face_count; ++f) {
    const physics::Face& face = view.faces[f];
    const Vec3 normal = math::rotated(pose.orientation, face.normal);
    if (math::dot(normal, camera.towards()) <= 0) continue;
    Patch patch{.outline_m = {}, .brightness = brightness_of(normal)};
    for (std::size_t k = face.first_side; k < std::size_t{face.first_side} + face.side_count; ++k)
      patch.outline_m.push_back(
          camera.on_picture_m(in_world(pose, view.vertices_m[view.sides[k].vertex])));
    patches.push_back(std::move(patch));
  }
  return patches;
}

Look look_of(const physics::Shape& shape, const Pose& pose, const Camera& camera) {
  Look look;
  look.centre_m = camera.on_picture_m(pose.position_m);
  if (const auto* sphere = std::get_if<physics::Sphere>(&shape)) {
    look.is_disc = true;
    look.radius_m = sphere->radius_m;
    return look;
  }
  const auto& compound = *std::get<std::shared_ptr<const physics::Compound>>(shape);
  look.radius_m = compound.r_outer_m();
  for (const physics::ConvexPolyhedron& part : compound.parts)
    std::ranges::move(faces_of(part.view(), pose, camera), std::back_inserter(look.patches));
  for (const physics::RoundPiece& part : compound.round_parts)
    look.patches.push_back(outline_of(part, pose, camera));
  return look;
}

}  // namespace sleight::scene_pictures
