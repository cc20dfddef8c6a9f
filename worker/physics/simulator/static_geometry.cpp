#include "worker/physics/simulator/static_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sleight::physics {
namespace {

std::string name_of(std::string_view kind, const std::string& given, std::size_t index) {
  return given.empty() ? fmt::format("{} {}", kind, index) : fmt::format("{} '{}'", kind, given);
}

/// A box of points, rounded outwards, and wider by what counts as a touch.
Box box_around(std::span<const Vec3> points_m) {
  Box box;
  for (int i = 0; i < 3; ++i) {
    double low = points_m[0][i];
    double high = low;
    for (const Vec3& p : points_m) {
      low = std::min(low, p[i]);
      high = std::max(high, p[i]);
    }
    const auto axis = static_cast<std::size_t>(i);
    constexpr float k_infinity = std::numeric_limits<float>::infinity();
    box.low_m[axis] = std::nextafter(static_cast<float>(low - 2 * k_touch_m), -k_infinity);
    box.high_m[axis] = std::nextafter(static_cast<float>(high + 2 * k_touch_m), k_infinity);
  }
  return box;
}

}  // namespace

StaticGeometry::StaticGeometry(const Scene& scene) {
  // Planes come first, under the same index as features and as pieces.
  for (const StaticPlane& plane : scene.planes) {
    const StaticOwner owner{static_cast<std::uint32_t>(names_.size()), plane.material};
    names_.push_back(name_of("plane", plane.name, planes_.size()));
    planes_.push_back(plane.outside);
    features_.push_back({.kind = FeatureKind::face,
                         .point_m = plane.outside.offset_m * plane.outside.normal,
                         .direction = plane.outside.normal});
    feature_owners_.push_back(owner);
    piece_owners_.push_back(owner);
  }
  plane_count_ = planes_.size();

  views_.reserve(scene.convexes.size());
  for (const StaticConvex& convex : scene.convexes) {
    const StaticOwner owner{static_cast<std::uint32_t>(names_.size()), convex.material};
    names_.push_back(name_of("convex", convex.name, views_.size()));
    views_.push_back(convex.polyhedron->view());
    pieces_.push_back({.view = &views_.back(), .reach_m = std::numeric_limits<double>::infinity()});
    piece_boxes_.push_back(box_around(convex.polyhedron->vertices_m()));
    piece_owners_.push_back(owner);
    add_features(views_.back(), owner);
  }
  feature_tree_ = BoxTree(feature_boxes_);
  piece_tree_ = BoxTree(piece_boxes_);
}

/// Faces with their sides closed, edges and vertices open: see RegionSide.
void StaticGeometry::add_features(const ConvexView& view, StaticOwner owner) {
  const auto add = [&](SphereFeature feature, std::uint32_t first_side,
                       std::span<const Vec3> points_m) {
    feature.regions_begin = first_side;
    feature.regions_end = static_cast<std::uint32_t>(sides_.size());
    features_.push_back(feature);
    feature_owners_.push_back(owner);
    feature_boxes_.push_back(box_around(points_m));
  };
  std::vector<Vec3> corners_m;
  for (std::size_t f = 0; f < view.face_count; ++f) {
    const Face& face = view.faces[f];
    const auto first = static_cast<std::uint32_t>(sides_.size());
    corners_m.clear();
    for (std::size_t k = 0; k < face.side_count; ++k) {
      const Side& side = view.sides[face.first_side + k];
      corners_m.push_back(view.vertices_m[side.vertex]);
      sides_.push_back({.space = {side.inward, side.offset_m}, .strict = false});
    }
    add({.kind = FeatureKind::face,
         .point_m = face.offset_m * face.normal,
         .direction = face.normal},
        first, corners_m);
  }
  for (std::size_t e = 0; e < view.edge_count; ++e) {
    const Edge& edge = view.edges[e];
    const std::array ends_m{view.vertices_m[edge.vertex[0]], view.vertices_m[edge.vertex[1]]};
    const Vec3 direction = math::normalized(ends_m[1] - ends_m[0]);
    const auto first = static_cast<std::uint32_t>(sides_.size());
    sides_.push_back({.space = {direction, math::dot(direction, ends_m[0])}, .strict = true});
    sides_.push_back({.space = {-direction, -math::dot(direction, ends_m[1])}, .strict = true});
    for (const std::uint16_t s : edge.side) {
      const Side& side = view.sides[s];
      sides_.push_back({.space = {-side.inward, -side.offset_m}, .strict = true});
    }
    add({.kind = FeatureKind::edge, .point_m = ends_m[0], .direction = direction}, first, ends_m);
  }
  for (std::uint16_t v = 0; v < view.vertex_count; ++v) {
    const Vec3 point_m = view.vertices_m[v];
    const auto first = static_cast<std::uint32_t>(sides_.size());
    for (std::size_t e = 0; e < view.edge_count; ++e) {
      const Edge& edge = view.edges[e];
      if (edge.vertex[0] != v && edge.vertex[1] != v) continue;
      // The direction as the edge has it, so that a point is on one side for both or for neither.
      const Vec3 start_m = view.vertices_m[edge.vertex[0]];
      const Vec3 end_m = view.vertices_m[edge.vertex[1]];
      const Vec3 direction = math::normalized(end_m - start_m);
      if (edge.vertex[0] == v) {
        sides_.push_back({.space = {-direction, -math::dot(direction, start_m)}, .strict = false});
      } else {
        sides_.push_back({.space = {direction, math::dot(direction, end_m)}, .strict = false});
      }
    }
    add({.kind = FeatureKind::vertex, .point_m = point_m}, first, std::span(&point_m, 1));
  }
}

bool reaches(const HalfSpace& outside, const Box& box) {
  // The corner that lies deepest, and more than its rounding deeper.
  double deepest_m = -outside.offset_m;
  double size_m = std::fabs(outside.offset_m);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    const double slope = outside.normal[i];
    const double term_m = slope * double{slope > 0 ? box.low_m[axis] : box.high_m[axis]};
    deepest_m += term_m;
    size_m += std::fabs(term_m);
  }
  return deepest_m <= size_m * k_rounding_ulps;
}

void StaticGeometry::near(const Box& box, const BoxTree& tree,
                          std::vector<std::uint32_t>& found) const {
  for (std::uint32_t i = 0; i < plane_count(); ++i) {
    if (reaches(planes_[i], box)) found.push_back(i);
  }
  const auto planes = static_cast<std::ptrdiff_t>(found.size());
  tree.for_each_overlap(box, [&](std::uint32_t i) { found.push_back(plane_count() + i); });
  std::sort(found.begin() + planes, found.end());
}

}  // namespace sleight::physics
