#include "clients/pictures/scene_view.h"

#include <algorithm>
#include <utility>

#include "clients/shapes/facets.h"

namespace sleight::pictures {
namespace {

using math::Quat;
using math::Vec3;

/// Maps a part's frame to the scene's frame.
struct Frame {
  Vec3 origin_m;
  Quat turn;

  Vec3 at(const Vec3& place_m) const { return origin_m + math::rotated(turn, place_m); }
};

Frame frame_of(const scene::Part& part, const motion::Pose& pose) {
  return {.origin_m = pose.centre_m + math::rotated(pose.orientation, part.position_m),
          .turn = math::composed(pose.orientation, part.orientation)};
}

/// A face is visible if its outward normal's component towards the viewer is at least this.
constexpr double k_facing_min = 0.02;

double towards_viewer(const Vec3& direction, Seen seen) {
  return seen == Seen::from_above ? direction.z() : -direction.y();
}

Vec3 middle_of(std::span<const Vec3> corners) {
  Vec3 sum{0, 0, 0};
  for (const Vec3& corner : corners)
    sum += corner;
  return sum / static_cast<double>(corners.size());
}

bool is_seen(const shapes::Facet& facet, std::span<const Vec3> corners_m, Seen seen) {
  if (facet.is_seen_from_behind) return true;
  const Vec3 normal =
      math::cross(Vec3(corners_m[1] - corners_m[0]), Vec3(corners_m[2] - corners_m[0]));
  return towards_viewer(normal, seen) > k_facing_min * math::norm(normal);
}

}  // namespace

plot::Point projected(const Vec3& place, Seen seen) {
  return {place.x(), seen == Seen::from_above ? place.y() : place.z()};
}

plot::Point projected_mm(const Vec3& place_m, Seen seen) {
  return projected(Vec3(k_mm_per_m * place_m), seen);
}

double depth_mm(const Vec3& place_m, Seen seen) {
  return k_mm_per_m * towards_viewer(place_m, seen);
}

std::vector<FlatPiece> flat_pieces(const scene::Scene& scene, const scene::Part& part,
                                   const motion::Pose& pose, Seen seen,
                                   std::span<const Vec3> offsets_m) {
  const Frame frame = frame_of(part, pose);
  std::vector<FlatPiece> pieces;
  const auto add = [&](const Vec3& middle_m) -> FlatPiece& {
    return pieces.emplace_back(FlatPiece{.middle_mm = projected_mm(middle_m, seen),
                                         .depth_mm = depth_mm(middle_m, seen),
                                         .height_mm = k_mm_per_m * middle_m.z()});
  };
  if (part.shape == scene::Shape::sphere) {
    add(frame.origin_m).radius_mm = 0.5 * k_mm_per_m * part.size_m.x();
    return pieces;
  }
  for (const shapes::Facet& facet : shapes::facets_of(scene, part, offsets_m)) {
    std::vector<Vec3> corners_m;
    for (const Vec3& corner : facet.corners_m)
      corners_m.push_back(frame.at(corner));
    if (!is_seen(facet, corners_m, seen)) continue;
    std::vector<plot::Point> corners_mm;
    for (const Vec3& corner : corners_m)
      corners_mm.push_back(projected_mm(corner, seen));
    if (facet.is_pip) {
      pieces.back().pips_mm.push_back(std::move(corners_mm));
      continue;
    }
    FlatPiece& piece = add(middle_of(corners_m));
    piece.corners_mm = std::move(corners_mm);
    piece.face = facet.face;
  }
  std::ranges::stable_sort(pieces, {}, &FlatPiece::depth_mm);
  return pieces;
}

double reach_mm(const scene::Scene& scene, std::uint32_t body) {
  double reach_m = 0;
  for (const scene::Part& part : parts_of(scene.parts, body)) {
    double part_m =
        part.shape == scene::Shape::sphere ? 0.5 * part.size_m.x() : 0.5 * math::norm(part.size_m);
    for (std::uint32_t i = 0; i < part.triangles; ++i) {
      for (const std::uint32_t vertex : scene.triangles[part.first_triangle + i])
        part_m = std::max(part_m, math::norm(scene.vertices[vertex].place_m));
    }
    reach_m = std::max(reach_m, math::norm(part.position_m) + part_m);
  }
  return k_mm_per_m * reach_m;
}

std::span<const scene::Part> parts_of(std::span<const scene::Part> parts, std::uint32_t feature) {
  const auto found = std::ranges::equal_range(parts, feature, {}, &scene::Part::feature);
  return {found.begin(), found.end()};
}

}  // namespace sleight::pictures
