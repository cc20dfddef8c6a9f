// The features of a mesh, and how they change when vertices move.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <set>

#include "common/base/check.h"
#include "worker/physics/scene/static_geometry.h"
#include "worker/physics/scene/static_regions.h"

namespace sleight::physics {
namespace {

/// Whether a sphere can touch the edge before it touches an adjacent face.
bool is_met(const MeshEdge& edge, bool closed) {
  return closed ? edge.kind == EdgeKind::convex : edge.kind != EdgeKind::flat;
}

}  // namespace

void StaticGeometry::add_features(MeshPlace& place) {
  const TriangleMesh& mesh = *place.mesh;
  const auto triangles = static_cast<std::uint32_t>(mesh.triangles().size());
  const auto edges = static_cast<std::uint32_t>(mesh.edges().size());
  const auto vertices = static_cast<std::uint32_t>(mesh.vertices_m().size());
  // Reserve the maximum number of sides. A face has three borders and its own plane. An edge has
  // two ends and two faces. A vertex has one side per edge.
  const std::uint32_t faces = place.closed ? triangles : 2 * triangles;
  place.first_edge = place.range.features_begin + faces;
  place.first_vertex = place.first_edge + edges;
  place.face_sides = side_count();
  place.edge_sides = place.face_sides + 4 * faces;
  std::uint32_t sides = place.edge_sides + 4 * edges;
  place.face_margins_m.resize(triangles);
  place.end_sides.resize(edges);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    place.vertex_sides.push_back(sides);
    for (const std::uint32_t e : mesh.edges_at(v))
      place.end_sides[e][mesh.edges()[e].vertex[0] == v ? 0 : 1] = sides++;
  }
  place.vertex_sides.push_back(sides);
  features_.resize(place.first_vertex + vertices);
  feature_owners_.resize(features_.size(), place.owner);
  feature_boxes_.resize(features_.size() - plane_count_);
  sides_.resize(sides);
  lay_out(place);
  write_all(place);
  write_boxes(place);
}

/// Writes the data that never changes.
void StaticGeometry::lay_out(MeshPlace& place) {
  for (std::uint32_t f = place.range.features_begin; f < place.first_edge; ++f) {
    const std::uint32_t side = place.face_sides + 4 * (f - place.range.features_begin);
    const bool back = !place.closed && (f - place.range.features_begin) % 2 == 1;
    features_[f] = {.kind = FeatureKind::face, .regions_begin = side, .regions_end = side + 4};
    for (std::uint32_t k = 0; k < 4; ++k)
      sides_[side + k].strict = back && k == 3;
  }
  for (std::uint32_t f = place.first_edge; f < place.first_vertex; ++f)
    features_[f] = {.kind = FeatureKind::edge};
  for (std::uint32_t side = place.edge_sides; side < place.vertex_sides.front(); ++side)
    sides_[side].strict = true;
  for (std::uint32_t f = place.first_vertex; f < feature_count(); ++f)
    features_[f] = {.kind = FeatureKind::vertex};
  for (std::uint32_t side = place.vertex_sides.front(); side < side_count(); ++side)
    sides_[side].strict = false;
}

void StaticGeometry::write_all(MeshPlace& place) {
  const TriangleMesh& mesh = *place.mesh;
  const std::size_t triangles = mesh.triangles().size();
  const std::size_t edges = mesh.edges().size();
  const std::size_t vertices = mesh.vertices_m().size();
  every_.resize(std::max({triangles, edges, vertices}));
  std::iota(every_.begin(), every_.end(), 0U);
  for (std::uint32_t t = 0; t < triangles; ++t)
    write_margins(place, t);
  write_faces(place, std::span(every_).first(triangles));
  write_edges(place, std::span(every_).first(edges));
  write_vertices(place, std::span(every_).first(vertices));
}

void StaticGeometry::refresh(std::size_t index) {
  CHECK(!moving_.others);
  if (!moving_.spheres) return;
  MeshPlace& place = meshes_[index];
  const TriangleMesh& mesh = *place.mesh;
  const Margins margins = margins_of(mesh.vertices_m());
  if (margins.border_m != place.margins.border_m) {
    // The mesh's largest coordinate changed, so every region changes by a rounding error.
    place.margins = margins;
    write_all(place);
    refreshed_.resize(place.first_vertex + mesh.vertices_m().size() - place.range.features_begin);
    std::ranges::generate(refreshed_, [next = place.range.features_begin]() mutable {
      const FeatureId now = next;
      ++next;
      return now;
    });
  } else {
    write_moved(place);
  }
  bool within = place.slack_m > 0;
  for (const std::uint32_t v : mesh.moved_vertices()) {
    if (!within) break;
    const Vec3& place_m = mesh.vertices_m()[v];
    const Vec3& home_m = place.homes_m[v];
    within = std::fabs(place_m.x() - home_m.x()) <= place.slack_m &&
             std::fabs(place_m.y() - home_m.y()) <= place.slack_m &&
             std::fabs(place_m.z() - home_m.z()) <= place.slack_m;
  }
  if (place.closed && !(within && place.keeps_side)) solids_[place.solid].hollow = is_hollow(mesh);
  if (within) return;
  write_boxes(place);
  ++boxes_made_;
  plant_feature_tree();
}

/// Rewrites the features that the mesh's last move changed.
void StaticGeometry::write_moved(MeshPlace& place) {
  const TriangleMesh& mesh = *place.mesh;
  // A face's margin depends on which of its edges are flat. So if an edge became flat or stopped
  // being flat, rewrite its faces too.
  beside_.clear();
  for (const std::uint32_t e : mesh.flat_changes()) {
    for (const std::uint32_t t : mesh.edges()[e].triangle) {
      if (t == k_no_triangle) continue;
      write_margins(place, t);
      beside_.push_back(t);
    }
  }
  write_faces(place, mesh.moved_triangles());
  write_faces(place, beside_);
  write_edges(place, mesh.moved_edges());
  write_vertices(place, mesh.moved_vertices());
  const std::uint32_t backs = place.closed ? 1 : 2;
  refreshed_.resize(backs * (mesh.moved_triangles().size() + beside_.size()) +
                    mesh.moved_edges().size() + mesh.moved_vertices().size());
  auto next = refreshed_.begin();
  const auto add = [&](std::span<const std::uint32_t> numbers, std::uint32_t first,
                       std::uint32_t each) {
    for (const std::uint32_t number : numbers)
      *next++ = {first + each * number};
  };
  for (std::uint32_t back = 0; back < backs; ++back) {
    add(mesh.moved_triangles(), place.range.features_begin + back, backs);
    add(beside_, place.range.features_begin + back, backs);
  }
  add(mesh.moved_edges(), place.first_edge, 1);
  add(mesh.moved_vertices(), place.first_vertex, 1);
}

StaticGeometry::About StaticGeometry::about(std::size_t index, std::uint32_t vertex) const {
  const MeshPlace& place = meshes_[index];
  const TriangleMesh& mesh = *place.mesh;
  std::set<FeatureId> features;
  std::set<std::uint32_t> edges;
  std::set<FeatureId> faces_beside;
  const std::uint32_t backs = place.closed ? 1 : 2;
  const auto add_face = [&](std::uint32_t triangle, std::set<FeatureId>& to) {
    for (std::uint32_t back = 0; back < backs && triangle != k_no_triangle; ++back)
      to.insert({place.range.features_begin + backs * triangle + back});
  };
  for (std::uint32_t triangle = 0; triangle < mesh.triangles().size(); ++triangle) {
    const TriangleCorners& corners = mesh.triangles()[triangle];
    if (std::ranges::find(corners, vertex) == corners.end()) continue;
    add_face(triangle, features);
    for (const std::uint32_t corner : corners)
      features.insert({place.first_vertex + corner});
    for (const std::uint32_t edge : mesh.edges_of(triangle)) {
      features.insert({place.first_edge + edge});
      edges.insert(edge);
      for (const std::uint32_t beside : mesh.edges()[edge].triangle)
        add_face(beside, faces_beside);
    }
  }
  About about{.features = {features.begin(), features.end()},
              .beside = {},
              .edges = {edges.begin(), edges.end()}};
  std::ranges::set_difference(faces_beside, features, std::back_inserter(about.beside));
  return about;
}

void StaticGeometry::write_margins(MeshPlace& place, std::uint32_t triangle) const {
  const TriangleMesh& mesh = *place.mesh;
  for (std::size_t k = 0; k < 3; ++k) {
    const bool flat = mesh.edges()[mesh.edges_of(triangle)[k]].kind == EdgeKind::flat;
    place.face_margins_m[triangle][k] = flat ? place.margins.flat_m : place.margins.border_m;
  }
}

// The functions below load array addresses once, before their loops. The compiler can't prove that
// the loops' writes leave the addresses unchanged.

/// Writes the regions of faces. A sheet's faces have a region on each side.
void StaticGeometry::write_faces(const MeshPlace& place, std::span<const std::uint32_t> triangles) {
  const Vec3* const vertices_m = place.mesh->vertices_m().data();
  const TriangleCorners* const corners = place.mesh->triangles().data();
  const MeshFace* const faces = place.mesh->faces().data();
  const std::array<double, 3>* const margins_m = place.face_margins_m.data();
  SphereFeature* const features = features_.data() + place.range.features_begin;
  RegionSide* const all_sides = sides_.data() + place.face_sides;
  const std::uint32_t backs = place.closed ? 1 : 2;
  for (const std::uint32_t t : triangles) {
    const MeshFace& face = faces[t];
    const std::array<double, 3>& margin_m = margins_m[t];
    for (std::uint32_t back = 0; back < backs; ++back) {
      const std::size_t at = std::size_t{backs} * t + back;
      SphereFeature& feature = features[at];
      RegionSide* const sides = all_sides + 4 * at;
      feature.point_m = vertices_m[corners[t][0]];
      for (std::size_t k = 0; k < 3; ++k) {
        sides[k].space.normal = face.inward[k];
        sides[k].space.offset_m = face.inward_offset_m[k] - margin_m[k];
      }
      const Vec3 normal = back != 0 ? Vec3(-face.normal) : face.normal;
      feature.direction = normal;
      sides[3].space.normal = normal;
      sides[3].space.offset_m = back != 0 ? -face.offset_m : face.offset_m;
    }
  }
}

/// Writes the regions of edges. Each edge also is a side of its end vertices' regions; writes these
/// sides too.
void StaticGeometry::write_edges(const MeshPlace& place, std::span<const std::uint32_t> numbers) {
  const Vec3* const vertices_m = place.mesh->vertices_m().data();
  const MeshFace* const faces = place.mesh->faces().data();
  const MeshEdge* const edges = place.mesh->edges().data();
  const std::array<std::uint32_t, 2>* const end_sides = place.end_sides.data();
  const double border_m = place.margins.border_m;
  const bool closed = place.closed;
  const std::uint32_t edge_sides = place.edge_sides;
  SphereFeature* const features = features_.data() + place.first_edge;
  RegionSide* const all_sides = sides_.data();
  for (const std::uint32_t number : numbers) {
    const MeshEdge& edge = edges[number];
    SphereFeature& feature = features[number];
    const Vec3 direction = edge.direction;
    const Vec3 back = -direction;
    const double start = math::dot(direction, edge.start_m);
    const double end = math::dot(direction, vertices_m[edge.vertex[1]]);
    // Use the edge's own direction, as its region does, so that rounding can't put a point outside
    // both regions.
    HalfSpace& at_start = all_sides[end_sides[number][0]].space;
    HalfSpace& at_end = all_sides[end_sides[number][1]].space;
    at_start.normal = back;
    at_start.offset_m = -start - border_m;
    at_end.normal = direction;
    at_end.offset_m = end - border_m;
    feature.point_m = edge.start_m;
    feature.direction = direction;
    if (!is_met(edge, closed)) {
      feature.regions_begin = k_nothing;
      feature.regions_end = k_nothing + 1;
      continue;
    }
    const std::uint32_t first = edge_sides + 4 * number;
    RegionSide* const sides = all_sides + first;
    sides[0].space.normal = direction;
    sides[0].space.offset_m = start;
    sides[1].space.normal = back;
    sides[1].space.offset_m = -end;
    const auto beside = [&](std::size_t i) {
      const MeshFace& face = faces[edge.triangle[i]];
      sides[2 + i].space.normal = -face.inward[edge.side[i]];
      sides[2 + i].space.offset_m = -face.inward_offset_m[edge.side[i]];
    };
    const bool has_two = edge.triangle[1] != k_no_triangle;
    beside(0);
    if (has_two) beside(1);
    feature.regions_begin = first;
    feature.regions_end = first + (has_two ? 4 : 3);
  }
}

/// Writes vertices. If no edge at a vertex can be met, the vertex's region is empty. Otherwise
/// write_edges has already written the region's sides, one per edge.
void StaticGeometry::write_vertices(const MeshPlace& place,
                                    std::span<const std::uint32_t> vertices) {
  const TriangleMesh& mesh = *place.mesh;
  const auto is_met_in_sheet = [&](std::uint32_t vertex) {
    return std::ranges::any_of(mesh.edges_at(vertex),
                               [&](std::uint32_t e) { return is_met(mesh.edges()[e], false); });
  };
  SphereFeature* const features = features_.data() + place.first_vertex;
  for (const std::uint32_t v : vertices) {
    SphereFeature& feature = features[v];
    feature.point_m = mesh.vertices_m()[v];
    const bool met = place.closed ? mesh.exposed(v) : is_met_in_sheet(v);
    feature.regions_begin = met ? place.vertex_sides[v] : k_nothing;
    feature.regions_end = met ? place.vertex_sides[v + std::size_t{1}] : k_nothing + 1;
  }
}

void StaticGeometry::write_boxes(MeshPlace& place) {
  const TriangleMesh& mesh = *place.mesh;
  corner_boxes_.clear();
  for (const Vec3& v : mesh.vertices_m())
    corner_boxes_.push_back(wider(box_around(v), place.slack_m));
  if (place.slack_m > 0) {
    place.homes_m.assign(mesh.vertices_m().begin(), mesh.vertices_m().end());
    place.keeps_side = place.closed && keeps_side(mesh, place.slack_m);
  }
  const auto box_of = [&](std::uint32_t feature) -> Box& {
    return feature_boxes_[feature - plane_count_];
  };
  const std::uint32_t backs = place.closed ? 1 : 2;
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
    const TriangleCorners& corners = mesh.triangles()[t];
    const Box first_two = joined(corner_boxes_[corners[0]], corner_boxes_[corners[1]]);
    for (std::uint32_t back = 0; back < backs; ++back) {
      box_of(place.range.features_begin + backs * t + back) =
          joined(first_two, corner_boxes_[corners[2]]);
    }
  }
  for (std::uint32_t e = 0; e < mesh.edges().size(); ++e) {
    const auto& [start, end] = mesh.edges()[e].vertex;
    box_of(place.first_edge + e) = joined(corner_boxes_[start], corner_boxes_[end]);
  }
  for (std::uint32_t v = 0; v < mesh.vertices_m().size(); ++v)
    box_of(place.first_vertex + v) = corner_boxes_[v];
}

}  // namespace sleight::physics
