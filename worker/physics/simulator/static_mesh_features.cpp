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
  for (std::uint32_t v = 0; v < vertices; ++v) {
    place.vertex_sides.push_back(sides);
    sides += std::max(1U, static_cast<std::uint32_t>(mesh.edges_at(v).size()));
  }
  features_.resize(place.first_vertex + vertices);
  feature_owners_.resize(features_.size(), owner);
  feature_boxes_.resize(features_.size() - plane_count_);
  sides_.resize(sides);
  for (std::uint32_t t = 0; t < triangles; ++t)
    write_face(place, t);
  for (std::uint32_t e = 0; e < edges; ++e)
    write_edge(place, e);
  for (std::uint32_t v = 0; v < vertices; ++v)
    write_vertex(place, v);
  write_boxes(place);
  meshes_.push_back(std::move(place));
}

void StaticGeometry::refresh(std::size_t index) {
  CHECK(!for_pieces_);
  if (!for_spheres_) return;
  MeshPlace& place = meshes_[index];
  const TriangleMesh& mesh = *place.mesh;
  const Margins margins = margins_of(mesh.vertices_m());
  refreshed_.clear();
  const auto face = [&](std::uint32_t t) {
    write_face(place, t);
    const std::uint32_t backs = place.closed ? 1 : 2;
    for (std::uint32_t back = 0; back < backs; ++back)
      refreshed_.push_back(place.first_face + backs * t + back);
  };
  const auto edge = [&](std::uint32_t e) {
    write_edge(place, e);
    refreshed_.push_back(place.first_edge + e);
  };
  const auto vertex = [&](std::uint32_t v) {
    write_vertex(place, v);
    refreshed_.push_back(place.first_vertex + v);
  };
  if (margins.border_m != place.margins.border_m) {
    // The size of the whole has changed, and every region by a rounding.
    place.margins = margins;
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t)
      face(t);
    for (std::uint32_t e = 0; e < mesh.edges().size(); ++e)
      edge(e);
    for (std::uint32_t v = 0; v < mesh.vertices_m().size(); ++v)
      vertex(v);
  }
  // How far a face reaches depends on how flat its edges are, so faces beside those that moved are
  // written too: once, at the first of their edges.
  is_written_.resize(mesh.triangles().size());
  for (const std::uint32_t e : mesh.moved_edges()) {
    edge(e);
    for (const std::uint32_t t : mesh.edges()[e].triangle) {
      if (t == k_no_triangle || is_written_[t] != 0) continue;
      is_written_[t] = 1;
      face(t);
    }
  }
  for (const std::uint32_t e : mesh.moved_edges()) {
    for (const std::uint32_t t : mesh.edges()[e].triangle) {
      if (t != k_no_triangle) is_written_[t] = 0;
    }
  }
  if (place.closed) solids_[place.solid].hollow = is_hollow(mesh);
  bool within = place.slack_m > 0;
  for (const std::uint32_t v : mesh.moved_vertices()) {
    vertex(v);
    for (int i = 0; i < 3 && within; ++i)
      within = std::fabs(mesh.vertices_m()[v][i] - place.homes_m[v][i]) <= place.slack_m;
  }
  if (within) return;
  write_boxes(place);
  if (place.closed) {
    Box& box = solids_[place.solid].box;
    box = wider(box_around(mesh.vertices_m()), place.slack_m);
  }
  plant_feature_tree();
}

/// A region that holds nothing.
void StaticGeometry::set_absent(SphereFeature& feature) {
  feature.regions_end = feature.regions_begin + 1;
  sides_[feature.regions_begin] = closed_side(Vec3::Zero(), 1, 0);
}

/// The region above a face, or below it.
void StaticGeometry::write_face(const MeshPlace& place, std::uint32_t triangle) {
  const TriangleMesh& mesh = *place.mesh;
  const MeshFace& face = mesh.faces()[triangle];
  const Vec3& corner_m = mesh.vertices_m()[mesh.triangles()[triangle][0]];
  for (std::uint32_t back = 0; back < (place.closed ? 1U : 2U); ++back) {
    const std::uint32_t at = place.closed ? triangle : 2 * triangle + back;
    std::uint32_t side = place.face_sides + 4 * at;
    features_[place.first_face + at] = {.kind = FeatureKind::face,
                                        .point_m = corner_m,
                                        .direction = back != 0 ? Vec3(-face.normal) : face.normal,
                                        .regions_begin = side,
                                        .regions_end = side + 4};
    for (std::size_t k = 0; k < 3; ++k) {
      const bool flat = mesh.edges()[mesh.edges_of(triangle)[k]].kind == EdgeKind::flat;
      sides_[side++] = closed_side(face.inward[k], face.inward_offset_m[k],
                                   flat ? place.margins.flat_m : place.margins.border_m);
    }
    sides_[side] = back != 0 ? open_side(-face.normal, -face.offset_m)
                             : closed_side(face.normal, face.offset_m, 0);
  }
}

void StaticGeometry::write_edge(const MeshPlace& place, std::uint32_t index) {
  const TriangleMesh& mesh = *place.mesh;
  const MeshEdge& edge = mesh.edges()[index];
  const std::uint32_t first = place.edge_sides + 4 * index;
  SphereFeature& feature = features_[place.first_edge + index];
  feature = {.kind = FeatureKind::edge,
             .point_m = edge.start_m,
             .direction = edge.direction,
             .regions_begin = first};
  if (!is_met(edge, place.closed)) {
    set_absent(feature);
    return;
  }
  std::uint32_t side = first;
  const Vec3& direction = edge.direction;
  const Vec3& end_m = mesh.vertices_m()[edge.vertex[1]];
  sides_[side++] = open_side(direction, math::dot(direction, edge.start_m));
  sides_[side++] = open_side(-direction, -math::dot(direction, end_m));
  for (const std::uint32_t t : edge.triangle) {
    if (t == k_no_triangle) continue;
    const auto& edges = mesh.edges_of(t);
    const auto k = static_cast<std::size_t>(std::ranges::find(edges, index) - edges.begin());
    const MeshFace& face = mesh.faces()[t];
    sides_[side++] = open_side(-face.inward[k], -face.inward_offset_m[k]);
  }
  feature.regions_end = side;
}

/// A vertex at which some edge is met. All edges at it bound its region.
void StaticGeometry::write_vertex(const MeshPlace& place, std::uint32_t vertex) {
  const TriangleMesh& mesh = *place.mesh;
  const Vec3& place_m = mesh.vertices_m()[vertex];
  SphereFeature& feature = features_[place.first_vertex + vertex];
  feature = {
      .kind = FeatureKind::vertex, .point_m = place_m, .regions_begin = place.vertex_sides[vertex]};
  std::uint32_t side = feature.regions_begin;
  bool met = false;
  for (const std::uint32_t e : mesh.edges_at(vertex)) {
    const MeshEdge& edge = mesh.edges()[e];
    met = met || is_met(edge, place.closed);
    // The direction as the edge has it, so that a point is on one side for both or for neither.
    const Vec3& direction = edge.direction;
    sides_[side++] =
        edge.vertex[0] == vertex
            ? closed_side(-direction, -math::dot(direction, edge.start_m), place.margins.border_m)
            : closed_side(direction, math::dot(direction, place_m), place.margins.border_m);
  }
  feature.regions_end = side;
  if (!met) set_absent(feature);
}

void StaticGeometry::write_boxes(MeshPlace& place) {
  const TriangleMesh& mesh = *place.mesh;
  corner_boxes_.clear();
  for (const Vec3& v : mesh.vertices_m())
    corner_boxes_.push_back(wider(box_around(v), place.slack_m));
  if (place.slack_m > 0) place.homes_m.assign(mesh.vertices_m().begin(), mesh.vertices_m().end());
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
