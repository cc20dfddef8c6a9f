#include "worker/physics/scene/static_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "worker/physics/scene/static_regions.h"

namespace sleight::physics {
namespace {

bool inside(const ConvexPolyhedron& polyhedron, const Vec3& point_m) {
  return std::ranges::all_of(polyhedron.faces(), [&](const Face& face) {
    return math::dot(face.normal, point_m) < face.offset_m;
  });
}

/// Returns how often a triangle's outline, seen from above, winds around a point: once
/// anticlockwise (1) or clockwise (-1), or not at all (0). Returns 0 if the triangle is below the
/// point. The sum over a closed mesh is the mesh's winding number around the point: two triangles
/// at an edge agree on which side of the edge the point is, because both compute the same numbers.
int turns_above(const TriangleMesh& mesh, std::uint32_t triangle, const Vec3& point_m) {
  const TriangleCorners& corners = mesh.triangles()[triangle];
  int turns = 0;
  bool any_higher = false;
  bool any_lower = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& a = mesh.vertices_m()[corners[k]];
    const Vec3& b = mesh.vertices_m()[corners[(k + 1) % 3]];
    (a.z() > point_m.z() ? any_higher : any_lower) = true;
    const bool upwards = a.y() <= point_m.y();
    if (upwards == (b.y() <= point_m.y())) continue;
    const Vec3& low = upwards ? a : b;
    const Vec3& high = upwards ? b : a;
    const bool is_left = (high.x() - low.x()) * (point_m.y() - low.y()) >
                         (high.y() - low.y()) * (point_m.x() - low.x());
    if (is_left) turns += upwards ? 1 : -1;
  }
  if (!any_lower || turns == 0) return turns;
  const MeshFace& face = mesh.faces()[triangle];
  const double over_m = math::dot(face.normal, point_m) - face.offset_m;
  return any_higher && turns * over_m < 0 ? turns : 0;
}

}  // namespace

std::string name_of_static(std::string_view kind, const std::string& given, std::size_t index) {
  std::string name(kind);
  return given.empty() ? name + " " + std::to_string(index) : name + " '" + given + "'";
}

struct StaticGeometry::Sizes {
  std::size_t features = 0;
  std::size_t sides = 0;
  std::size_t pieces = 0;
  std::size_t triangles = 0;
  std::size_t names = 0;
};

MovingKinds moving_kinds(const Scene& scene) {
  MovingKinds kinds;
  double radius_m = 0;
  for (const BodyDescription& body : scene.bodies) {
    if (body.fixed) continue;
    const auto* sphere = std::get_if<Sphere>(&body.shape);
    (sphere != nullptr ? kinds.spheres : kinds.others) = true;
    if (sphere != nullptr) radius_m = std::max(radius_m, sphere->radius_m);
  }
  int exponent = 0;
  if (std::frexp(radius_m, &exponent) > 0) kinds.radius_m_max = std::ldexp(1.0, exponent);
  return kinds;
}

StaticGeometry::StaticGeometry(const Scene& scene)
    : filter_(scene.filter), moving_(moving_kinds(scene)) {
  Sizes sizes{.features = scene.planes.size(),
              .names = scene.planes.size() + scene.convexes.size() + scene.meshes.size()};
  for (const StaticConvex& convex : scene.convexes) {
    const ConvexPolyhedron& hull = *convex.polyhedron;
    sizes.features += hull.faces().size() + hull.edges().size() + hull.vertices_m().size();
    sizes.sides += hull.sides().size() + hull.faces().size() + 6 * hull.edges().size();
    ++sizes.pieces;
  }
  for (const StaticMesh& placed : scene.meshes) {
    const TriangleMesh& mesh = *placed.mesh;
    const std::size_t triangles = mesh.triangles().size();
    sizes.features += 2 * triangles + mesh.edges().size() + mesh.vertices_m().size();
    sizes.sides += 8 * triangles + 6 * mesh.edges().size();
    sizes.pieces += triangles;
    sizes.triangles += triangles;
  }
  ++sizes.sides;
  reserve(sizes);
  if (moving_.spheres) sides_.push_back(closed_side(Vec3::Zero(), 1, 0));
  for (const StaticPlane& plane : scene.planes)
    add_plane(plane);
  plane_count_ = planes_.size();
  for (std::size_t i = 0; i < scene.convexes.size(); ++i) {
    names_.push_back(name_of_static("convex", scene.convexes[i].name, i));
    add_convex(scene.convexes[i]);
  }
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    names_.push_back(name_of_static("mesh", scene.meshes[i].name, i));
    add_mesh(scene.meshes[i]);
  }
  plant_feature_tree();
  piece_tree_ = BoxTree(piece_boxes_);
}

/// Builds the tree of all features that can be met, now or after vertices have moved within the
/// slack.
void StaticGeometry::plant_feature_tree() {
  in_feature_tree_.clear();
  tree_boxes_.clear();
  const auto add = [&](std::uint32_t from, std::uint32_t to, bool all) {
    for (std::uint32_t i = from; i < to; ++i) {
      if (!all && is_absent(features_[i])) continue;
      in_feature_tree_.push_back({i});
      tree_boxes_.push_back(feature_boxes_[i - plane_count_]);
    }
  };
  std::uint32_t done = plane_count();
  for (const MeshPlace& place : meshes_) {
    add(done, place.range.features_begin, false);
    add(place.range.features_begin, place.range.features_end, place.slack_m > 0);
    done = place.range.features_end;
  }
  add(done, feature_count(), false);
  feature_tree_ = BoxTree(tree_boxes_);
}

void StaticGeometry::reserve(const Sizes& sizes) {
  names_.reserve(sizes.names);
  piece_owners_.reserve(sizes.names + sizes.pieces);
  if (moving_.spheres) {
    features_.reserve(sizes.features);
    feature_owners_.reserve(sizes.features);
    feature_boxes_.reserve(sizes.features);
    sides_.reserve(sizes.sides);
  }
  if (moving_.others) {
    triangles_.reserve(sizes.triangles);
    views_.reserve(sizes.pieces);
    pieces_.reserve(sizes.pieces);
    piece_boxes_.reserve(sizes.pieces);
  }
}

StaticGeometry::Margins StaticGeometry::margins_of(std::span<const Vec3> vertices_m) const {
  double size_m = moving_.radius_m_max;
  for (const Vec3& v : vertices_m)
    size_m = std::max({size_m, std::fabs(v.x()), std::fabs(v.y()), std::fabs(v.z())});
  const double border_m = k_rounding_ulps * size_m;
  // If two faces are flat to k_mesh_flat_sine, `flat_m` bounds the distance between their prisms.
  return {.border_m = border_m, .flat_m = border_m + 4 * k_mesh_flat_sine * moving_.radius_m_max};
}

void StaticGeometry::add_plane(const StaticPlane& plane) {
  const StaticOwner owner{static_cast<std::uint32_t>(names_.size()), plane.material, plane.group};
  names_.push_back(name_of_static("plane", plane.name, planes_.size()));
  if (plane.friction_map) {
    friction_maps_.resize(planes_.size() + 1);
    friction_maps_.back() = plane.friction_map;
  }
  planes_.push_back(plane.outside);
  features_.push_back({.kind = FeatureKind::face,
                       .point_m = plane.outside.offset_m * plane.outside.normal,
                       .direction = plane.outside.normal});
  feature_owners_.push_back(owner);
  piece_owners_.push_back(owner);
}

void StaticGeometry::add_convex(const StaticConvex& convex) {
  const StaticOwner owner{static_cast<std::uint32_t>(names_.size() - 1), convex.material,
                          convex.group};
  const ConvexView view = convex.polyhedron->view();
  const Box box = box_around(convex.polyhedron->vertices_m());
  solids_.push_back({.owner = owner, .polyhedron = convex.polyhedron, .mesh = {}});
  if (moving_.spheres) add_features(view, owner);
  if (moving_.others) add_piece(view, box, owner);
}

void StaticGeometry::add_mesh(const StaticMesh& placed) {
  const StaticOwner owner{static_cast<std::uint32_t>(names_.size() - 1), placed.material,
                          placed.group};
  const TriangleMesh& mesh = *placed.mesh;
  MeshPlace place{.mesh = placed.mesh,
                  .owner = owner,
                  .solid = solids_.size(),
                  .closed = is_closed(mesh),
                  .slack_m = placed.slack_m,
                  .margins = margins_of(mesh.vertices_m()),
                  .range = {.features_begin = {feature_count()}, .pieces_begin = {piece_count()}}};
  if (place.closed)
    solids_.push_back({.owner = owner,
                       .polyhedron = {},
                       .mesh = placed.mesh,
                       .hollow = is_hollow(mesh),
                       .place = meshes_.size()});
  if (moving_.spheres) add_features(place);
  if (moving_.others) {
    for (const TriangleCorners& corners : mesh.triangles()) {
      const Vec3& a = mesh.vertices_m()[corners[0]];
      const Vec3& b = mesh.vertices_m()[corners[1]];
      const Vec3& c = mesh.vertices_m()[corners[2]];
      triangles_.emplace_back(a, b, c);
      add_piece(triangles_.back().view(),
                joined(joined(box_around(a), box_around(b)), box_around(c)), owner);
    }
  }
  place.range.features_end = {feature_count()};
  place.range.pieces_end = {piece_count()};
  meshes_.push_back(std::move(place));
}

void StaticGeometry::add_piece(const ConvexView& view, const Box& box, StaticOwner owner) {
  views_.push_back(view);
  pieces_.push_back({.view = &views_.back(), .reach_m = std::numeric_limits<double>::infinity()});
  piece_boxes_.push_back(box);
  piece_owners_.push_back(owner);
}

void StaticGeometry::add_feature(SphereFeature feature, std::uint32_t first_side, const Box& box,
                                 StaticOwner owner) {
  feature.regions_begin = first_side;
  feature.regions_end = side_count();
  features_.push_back(feature);
  feature_owners_.push_back(owner);
  feature_boxes_.push_back(box);
}

// ---- the features of a convex -------------------------------------------------------------------

void StaticGeometry::add_features(const ConvexView& view, StaticOwner owner) {
  const std::span<const Vec3> vertices_m(view.vertices_m, view.vertex_count);
  const double margin_m = margins_of(vertices_m).border_m;
  corner_boxes_.clear();
  for (const Vec3& v : vertices_m)
    corner_boxes_.push_back(box_around(v));
  for (std::size_t f = 0; f < view.face_count; ++f) {
    const Face& face = view.faces[f];
    const std::uint32_t first = side_count();
    Box box = corner_boxes_[view.sides[face.first_side].vertex];
    for (std::size_t k = 0; k < face.side_count; ++k) {
      const Side& side = view.sides[face.first_side + k];
      box = joined(box, corner_boxes_[side.vertex]);
      sides_.push_back(closed_side(side.inward, side.offset_m, margin_m));
    }
    sides_.push_back(closed_side(face.normal, face.offset_m, 0));
    add_feature({.kind = FeatureKind::face,
                 .point_m = face.offset_m * face.normal,
                 .direction = face.normal},
                first, box, owner);
  }
  const auto direction_of = [&](const Edge& edge) {
    return math::normalized(vertices_m[edge.vertex[1]] - vertices_m[edge.vertex[0]]);
  };
  for (std::size_t e = 0; e < view.edge_count; ++e) {
    const Edge& edge = view.edges[e];
    const auto [start, end] = edge.vertex;
    const Vec3 direction = direction_of(edge);
    const std::uint32_t first = side_count();
    sides_.push_back(open_side(direction, math::dot(direction, vertices_m[start])));
    sides_.push_back(open_side(-direction, -math::dot(direction, vertices_m[end])));
    for (const std::uint16_t s : edge.side) {
      const Side& side = view.sides[s];
      sides_.push_back(open_side(-side.inward, -side.offset_m));
    }
    add_feature({.kind = FeatureKind::edge, .point_m = vertices_m[start], .direction = direction},
                first, joined(corner_boxes_[start], corner_boxes_[end]), owner);
  }
  for (std::uint16_t v = 0; v < view.vertex_count; ++v) {
    const std::uint32_t first = side_count();
    for (std::uint16_t i = view.ring_first[v]; i < view.ring_first[v + 1]; ++i) {
      // Use the edge's own direction, as its region does, so that rounding can't put a point
      // outside both regions.
      const Edge& edge = view.edges[view.ring_edges[i]];
      const Vec3 direction = direction_of(edge);
      const double offset_m = math::dot(direction, vertices_m[v]);
      sides_.push_back(edge.vertex[0] == v ? closed_side(-direction, -offset_m, margin_m)
                                           : closed_side(direction, offset_m, margin_m));
    }
    add_feature({.kind = FeatureKind::vertex, .point_m = vertices_m[v]}, first, corner_boxes_[v],
                owner);
  }
}

// ---- questions ----------------------------------------------------------------------------------

std::vector<StaticGeometry::MeshRange> StaticGeometry::meshes_shared_with(
    const StaticGeometry& other) const {
  std::vector<MeshRange> shared;
  for (std::size_t i = 0; i < std::min(meshes_.size(), other.meshes_.size()); ++i) {
    const MeshPlace& a = meshes_[i];
    const MeshPlace& b = other.meshes_[i];
    if (a.mesh == b.mesh && a.owner.material == b.owner.material &&
        a.owner.group == b.owner.group && a.margins == b.margins && a.range == b.range)
      shared.push_back(a.range);
  }
  return shared;
}

bool StaticGeometry::is_solid_at(const Solid& solid, const Vec3& point_m) const {
  if (solid.polyhedron) return inside(*solid.polyhedron, point_m);
  const MeshRange& range = meshes_[solid.place].range;
  Box above = box_around(point_m);
  above.high_m[2] = std::numeric_limits<float>::infinity();
  int turns = solid.hollow ? 1 : 0;
  const auto look = [&](std::uint32_t triangle) {
    if (triangle < solid.mesh->triangles().size())
      turns += turns_above(*solid.mesh, triangle, point_m);
  };
  if (moving_.spheres) {
    feature_tree_.for_each_overlap(
        above, [&](std::uint32_t i) { look(in_feature_tree_[i] - range.features_begin); });
  } else {
    piece_tree_.for_each_overlap(
        above, [&](std::uint32_t i) { look(plane_count() + i - range.pieces_begin); });
  }
  return turns > 0;
}

const std::string* StaticGeometry::solid_at(const Vec3& point_m, CollisionGroup group) const {
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    if (math::dot(planes_[i].normal, point_m) < planes_[i].offset_m &&
        filter_.meet(group, piece_owners_[i].group))
      return &names_[i];
  }
  for (const Solid& solid : solids_) {
    if (filter_.meet(group, solid.owner.group) && is_solid_at(solid, point_m))
      return &names_[solid.owner.name];
  }
  return nullptr;
}

CentreRange::CentreRange(const Box& box, double radius_m) : reach_m(radius_m + k_touch_m) {
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    middle_m[i] = 0.5 * (double{box.low_m[axis]} + double{box.high_m[axis]});
    half_m[i] = 0.5 * (double{box.high_m[axis]} - double{box.low_m[axis]}) - radius_m;
  }
  away_m = reach_m + math::norm(half_m);
}

bool reaches(const HalfSpace& outside, const Box& box) {
  // Find the deepest corner, and bound the error of its depth.
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

void StaticGeometry::features_near(const Box& box, double radius_m,
                                   std::vector<StaticId>& found) const {
  const CentreRange centre(box, radius_m);
  for (std::uint32_t i = 0; i < plane_count(); ++i) {
    if (reaches(planes_[i], box) && may_meet({i}, centre)) found.push_back({i});
  }
  // Compute the range of the sphere's centre, and a reach that covers rounding and touches.
  Box centres;
  float size_m = 0;
  const auto radius = static_cast<float>(radius_m);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float low = box.low_m[axis] + radius;
    const float high = box.high_m[axis] - radius;
    centres.low_m[axis] = std::min(low, high);
    centres.high_m[axis] = std::max(low, high);
    size_m = std::max({size_m, std::fabs(box.low_m[axis]), std::fabs(box.high_m[axis])});
  }
  const float reach_m = radius + static_cast<float>(2 * k_touch_m) + 0x1p-21F * (size_m + radius);
  const auto in_tree = static_cast<std::ptrdiff_t>(found.size());
  feature_tree_.for_each_within(centres, reach_m, [&](std::uint32_t i) {
    const FeatureId index = in_feature_tree_[i];
    if (!is_absent(features_[index]) && may_meet(index, centre)) found.push_back({index});
  });
  std::sort(found.begin() + in_tree, found.end());
}

void StaticGeometry::pieces_near(const Box& box, std::vector<StaticId>& found) const {
  for (std::uint32_t i = 0; i < plane_count(); ++i) {
    if (reaches(planes_[i], box)) found.push_back({i});
  }
  const auto in_tree = static_cast<std::ptrdiff_t>(found.size());
  piece_tree_.for_each_overlap(box, [&](std::uint32_t i) { found.push_back({plane_count() + i}); });
  std::sort(found.begin() + in_tree, found.end());
}

}  // namespace sleight::physics
