// The features of a mesh, and what happens to them when vertices move.
#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "worker/physics/simulator/static_geometry.h"
#include "worker/physics/simulator/static_regions.h"

namespace sleight::physics {
namespace {

/// Whether a sphere can touch an edge itself rather than the faces beside it.
bool is_met(const MeshEdge& edge, bool closed) {
  return closed ? edge.kind == EdgeKind::convex : edge.kind != EdgeKind::flat;
}

}  // namespace

void StaticGeometry::add_features(const StaticMesh& placed, StaticOwner owner) {
  const TriangleMesh& mesh = *placed.mesh;
  const auto triangles = static_cast<std::uint32_t>(mesh.triangles().size());
  const auto edges = static_cast<std::uint32_t>(mesh.edges().size());
  const auto vertices = static_cast<std::uint32_t>(mesh.vertices_m().size());
  MeshPlace place{.mesh = placed.mesh,
                  .solid = solids_.size() - 1,
                  .closed = is_closed(mesh),
                  .slack_m = placed.slack_m,
                  .margins = margins_of(mesh.vertices_m())};
  // Room for all: of a face three sides and itself, of an edge its ends and two faces, of a vertex
  // one for each of its edges.
  const std::uint32_t faces = place.closed ? triangles : 2 * triangles;
  place.first_face = feature_count();
  place.first_edge = place.first_face + faces;
  place.first_vertex = place.first_edge + edges;
  place.face_sides = side_count();
  place.edge_sides = place.face_sides + 4 * faces;
  std::uint32_t sides = place.edge_sides + 4 * edges;
  place.end_sides.resize(edges);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    place.vertex_sides.push_back(sides);
    for (const std::uint32_t e : mesh.edges_at(v))
      place.end_sides[e][mesh.edges()[e].vertex[0] == v ? 0 : 1] = sides++;
  }
  place.vertex_sides.push_back(sides);
  features_.resize(place.first_vertex + vertices);
  feature_owners_.resize(features_.size(), owner);
  feature_boxes_.resize(features_.size() - plane_count_);
  sides_.resize(sides);
  lay_out(place);
  write_all(place);
  write_boxes(place);
  meshes_.push_back(std::move(place));
}

/// All that never changes.
void StaticGeometry::lay_out(MeshPlace& place) {
  for (std::uint32_t f = place.first_face; f < place.first_edge; ++f) {
    const std::uint32_t side = place.face_sides + 4 * (f - place.first_face);
    const bool back = !place.closed && (f - place.first_face) % 2 == 1;
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

void StaticGeometry::write_all(const MeshPlace& place) {
  for (std::uint32_t t = 0; t < place.mesh->triangles().size(); ++t)
    write_face(place, t);
  for (std::uint32_t e = 0; e < place.mesh->edges().size(); ++e)
    write_edge(place, e);
  for (std::uint32_t v = 0; v < place.mesh->vertices_m().size(); ++v)
    write_vertex(place, v);
}

void StaticGeometry::refresh(std::size_t index) {
  CHECK(!for_pieces_);
  if (!for_spheres_) return;
  MeshPlace& place = meshes_[index];
  const TriangleMesh& mesh = *place.mesh;
  const Margins margins = margins_of(mesh.vertices_m());
  refreshed_.clear();
  if (margins.border_m != place.margins.border_m) {
    // The size of the whole has changed, and every region by a rounding.
    place.margins = margins;
    write_all(place);
    for (std::uint32_t f = place.first_face; f < place.first_vertex + mesh.vertices_m().size(); ++f)
      refreshed_.push_back(f);
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
  if (place.closed) {
    Box& box = solids_[place.solid].box;
    box = wider(box_around(mesh.vertices_m()), place.slack_m);
  }
  plant_feature_tree();
}

/// What the mesh's last move has changed.
void StaticGeometry::write_moved(const MeshPlace& place) {
  const TriangleMesh& mesh = *place.mesh;
  const std::uint32_t backs = place.closed ? 1 : 2;
  const auto face = [&](std::uint32_t t) {
    write_face(place, t);
    for (std::uint32_t back = 0; back < backs; ++back)
      refreshed_.push_back(place.first_face + backs * t + back);
  };
  for (const std::uint32_t t : mesh.moved_triangles())
    face(t);
  // How far a face reaches depends on how flat its edges are.
  for (const std::uint32_t e : mesh.flat_changes()) {
    for (const std::uint32_t t : mesh.edges()[e].triangle) {
      if (t != k_no_triangle) face(t);
    }
  }
  for (const std::uint32_t e : mesh.moved_edges()) {
    write_edge(place, e);
    refreshed_.push_back(place.first_edge + e);
  }
  for (const std::uint32_t v : mesh.moved_vertices()) {
    write_vertex(place, v);
    refreshed_.push_back(place.first_vertex + v);
  }
}

/// The region above a face, or below it.
void StaticGeometry::write_face(const MeshPlace& place, std::uint32_t triangle) {
  const TriangleMesh& mesh = *place.mesh;
  const MeshFace& face = mesh.faces()[triangle];
  const Vec3& corner_m = mesh.vertices_m()[mesh.triangles()[triangle][0]];
  const std::array<std::uint32_t, 3>& edges = mesh.edges_of(triangle);
  for (std::uint32_t back = 0; back < (place.closed ? 1U : 2U); ++back) {
    const std::uint32_t at = place.closed ? triangle : 2 * triangle + back;
    SphereFeature& feature = features_[place.first_face + at];
    RegionSide* const sides = &sides_[place.face_sides + std::size_t{4} * at];
    feature.point_m = corner_m;
    for (std::size_t k = 0; k < 3; ++k) {
      const bool flat = mesh.edges()[edges[k]].kind == EdgeKind::flat;
      sides[k].space.normal = face.inward[k];
      sides[k].space.offset_m =
          face.inward_offset_m[k] - (flat ? place.margins.flat_m : place.margins.border_m);
    }
    if (back != 0) {
      feature.direction = -face.normal;
      sides[3].space.offset_m = -face.offset_m;
    } else {
      feature.direction = face.normal;
      sides[3].space.offset_m = face.offset_m;
    }
    sides[3].space.normal = feature.direction;
  }
}

/// An edge, and the sides that it is to its ends' regions.
void StaticGeometry::write_edge(const MeshPlace& place, std::uint32_t index) {
  const TriangleMesh& mesh = *place.mesh;
  const MeshEdge& edge = mesh.edges()[index];
  const Vec3& direction = edge.direction;
  const Vec3 back = -direction;
  const double start = math::dot(direction, edge.start_m);
  const double end = math::dot(direction, mesh.vertices_m()[edge.vertex[1]]);
  // The direction as the edge has it, so that a point is on one side for both or for neither.
  const auto& [at_start, at_end] = place.end_sides[index];
  sides_[at_start].space.normal = back;
  sides_[at_start].space.offset_m = -start - place.margins.border_m;
  sides_[at_end].space.normal = direction;
  sides_[at_end].space.offset_m = end - place.margins.border_m;
  SphereFeature& feature = features_[place.first_edge + index];
  feature.point_m = edge.start_m;
  feature.direction = direction;
  if (!is_met(edge, place.closed)) {
    feature.regions_begin = k_nothing;
    feature.regions_end = k_nothing + 1;
    return;
  }
  feature.regions_begin = place.edge_sides + 4 * index;
  RegionSide* const sides = &sides_[feature.regions_begin];
  sides[0].space.normal = direction;
  sides[0].space.offset_m = start;
  sides[1].space.normal = back;
  sides[1].space.offset_m = -end;
  const std::uint32_t faces = edge.triangle[1] == k_no_triangle ? 1 : 2;
  for (std::size_t i = 0; i < faces; ++i) {
    const MeshFace& face = mesh.faces()[edge.triangle[i]];
    sides[2 + i].space.normal = -face.inward[edge.side[i]];
    sides[2 + i].space.offset_m = -face.inward_offset_m[edge.side[i]];
  }
  feature.regions_end = feature.regions_begin + 2 + faces;
}

/// A vertex at which some edge is met. All edges at it bound its region, and have written it.
void StaticGeometry::write_vertex(const MeshPlace& place, std::uint32_t vertex) {
  const TriangleMesh& mesh = *place.mesh;
  SphereFeature& feature = features_[place.first_vertex + vertex];
  feature.point_m = mesh.vertices_m()[vertex];
  const bool met = place.closed ? mesh.exposed(vertex)
                                : std::ranges::any_of(mesh.edges_at(vertex), [&](std::uint32_t e) {
                                    return is_met(mesh.edges()[e], false);
                                  });
  feature.regions_begin = met ? place.vertex_sides[vertex] : k_nothing;
  feature.regions_end = met ? place.vertex_sides[vertex + std::size_t{1}] : k_nothing + 1;
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
      box_of(place.first_face + backs * t + back) = joined(first_two, corner_boxes_[corners[2]]);
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
