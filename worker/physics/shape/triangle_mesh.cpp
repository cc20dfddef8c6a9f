#include "worker/physics/shape/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/check.h"
#include "worker/physics/shape/face_pair.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

bool finite(const Vec3& p) {
  // Squares and cubes of lengths must not overflow.
  return std::fabs(p.x()) < 1e60 && std::fabs(p.y()) < 1e60 && std::fabs(p.z()) < 1e60;
}

struct DirectedSide {
  std::uint32_t low, high;
  std::uint32_t triangle;
  std::uint8_t side;
  bool forward;  ///< from low to high
  friend auto operator<=>(const DirectedSide&, const DirectedSide&) = default;
};

std::vector<DirectedSide> sides_of(std::span<const TriangleCorners> triangles) {
  std::vector<DirectedSide> sides;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t from = triangles[t][k];
      const std::uint32_t to = triangles[t][(k + 1U) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), t, k, from < to});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

/// Checks whether triangles may share an edge. `run` contains the sides at this edge.
std::optional<MeshError> error_of_edge(std::span<const DirectedSide> run, MeshClosure closure) {
  using Kind = MeshError::Kind;
  const DirectedSide& first = run[0];
  if (run.size() > 2)
    return MeshError{.kind = Kind::edge_shared_by_three,
                     .triangle = run[2].triangle,
                     .other = first.triangle,
                     .vertex = first.low};
  if (run.size() == 1 && closure == MeshClosure::closed)
    return MeshError{.kind = Kind::not_closed, .triangle = first.triangle, .vertex = first.low};
  if (run.size() == 2 && first.forward == run[1].forward)
    return MeshError{.kind = Kind::edge_run_twice,
                     .triangle = run[1].triangle,
                     .other = first.triangle,
                     .vertex = first.low};
  return std::nullopt;
}

/// Makes an edge from one side, or from two opposite sides. If there are two, triangle[0] is the
/// one whose side runs from the lower to the higher vertex.
MeshEdge edge_of(std::span<const DirectedSide> run) {
  const bool swapped = run.size() == 2 && !run[0].forward;
  const DirectedSide& left = swapped ? run[1] : run[0];
  MeshEdge edge;
  edge.vertex = left.forward ? std::array{left.low, left.high} : std::array{left.high, left.low};
  edge.triangle[0] = left.triangle;
  edge.side[0] = left.side;
  if (run.size() == 2) {
    const DirectedSide& right = swapped ? run[0] : run[1];
    edge.triangle[1] = right.triangle;
    edge.side[1] = right.side;
  }
  return edge;
}

}  // namespace

base::Result<TriangleMesh, MeshError> TriangleMesh::make(std::span<const Vec3> vertices_m,
                                                         std::span<const TriangleCorners> triangles,
                                                         MeshClosure closure) {
  using Kind = MeshError::Kind;
  TriangleMesh mesh;
  mesh.vertices_m_.assign(vertices_m.begin(), vertices_m.end());
  mesh.triangles_.assign(triangles.begin(), triangles.end());
  // Check each triangle alone, then each vertex, even if no triangle uses it.
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (const auto error = mesh.check_triangle(t)) return *error;
  }
  for (std::uint32_t v = 0; v < vertices_m.size(); ++v) {
    if (!finite(vertices_m[v])) return MeshError{.kind = Kind::vertex_not_finite, .vertex = v};
  }
  // Sides of the same edge are neighbours in the sorted list.
  const std::vector<DirectedSide> sides = sides_of(triangles);
  mesh.triangle_edges_.resize(triangles.size());
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high)
      ++end;
    const auto run = std::span(sides).subspan(i, end - i);
    if (const auto error = error_of_edge(run, closure)) return *error;
    for (; i < end; ++i)
      mesh.triangle_edges_[sides[i].triangle][sides[i].side] =
          static_cast<std::uint32_t>(mesh.edges_.size());
    mesh.edges_.push_back(edge_of(run));
  }
  mesh.index_vertices();
  // Derive all data that depend on positions.
  mesh.faces_.resize(triangles.size());
  mesh.exposing_edges_.resize(vertices_m.size());
  std::vector<std::uint32_t> all(triangles.size());
  std::iota(all.begin(), all.end(), 0U);
  mesh.derive_faces(all);
  all.resize(mesh.edges_.size());
  std::iota(all.begin(), all.end(), 0U);
  mesh.derive_edges(all);
  mesh.flat_changes_.clear();
  return mesh;
}

std::optional<MeshError> TriangleMesh::check_triangle(std::uint32_t triangle) const {
  using Kind = MeshError::Kind;
  const TriangleCorners& corners = triangles_[triangle];
  for (const std::uint32_t v : corners) {
    if (v >= vertices_m_.size())
      return MeshError{.kind = Kind::index_out_of_range, .triangle = triangle, .vertex = v};
    if (!finite(vertices_m_[v]))
      return MeshError{.kind = Kind::vertex_not_finite, .triangle = triangle, .vertex = v};
  }
  const Vec3& a = vertices_m_[corners[0]];
  const Vec3& b = vertices_m_[corners[1]];
  const Vec3& c = vertices_m_[corners[2]];
  // The root of the greatest square equals the greatest root, bit for bit.
  const Vec3 ab = b - a;
  const Vec3 bc = c - b;
  const Vec3 ca = a - c;
  const double longest = std::sqrt(std::max({dot(ab, ab), dot(bc, bc), dot(ca, ca)}));
  // Twice the area is the longest side times its height.
  if (!(norm(cross(b - a, c - a)) > k_mesh_sliver * (longest * longest)) ||
      !(longest > k_mesh_point_m))
    return MeshError{.kind = Kind::degenerate_triangle, .triangle = triangle, .vertex = corners[0]};
  return std::nullopt;
}

void TriangleMesh::index_vertices() {
  const auto index = [&](auto& first, auto& about, const auto& each) {
    first.assign(vertices_m_.size() + 1, 0);
    each([&](std::uint32_t vertex, std::uint32_t) { ++first[vertex + std::size_t{1}]; });
    for (std::size_t v = 1; v < first.size(); ++v)
      first[v] += first[v - 1];
    about.assign(first.back(), 0);
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    each([&](std::uint32_t vertex, std::uint32_t item) { about[next[vertex]++] = item; });
  };
  index(triangles_first_, triangles_about_, [&](const auto& visit) {
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      for (const std::uint32_t v : triangles_[t])
        visit(v, t);
    }
  });
  index(edges_first_, edges_about_, [&](const auto& visit) {
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      for (const std::uint32_t v : edges_[e].vertex)
        visit(v, e);
    }
  });
}

/// Returns false if any triangle is degenerate.
bool TriangleMesh::derive_faces(std::span<const std::uint32_t> triangles) {
  const auto corners_m = [&](std::uint32_t triangle) -> face_pair::Corners {
    const TriangleCorners& corners = triangles_[triangle];
    return {&vertices_m_[corners[0]], &vertices_m_[corners[1]], &vertices_m_[corners[2]]};
  };
  bool sound = true;
  for (std::size_t i = 0; i < triangles.size(); i += 2) {
    const std::uint32_t first = triangles[i];
    // If the number is odd, the last triangle is derived twice.
    const std::uint32_t second = triangles[std::min(i + 1, triangles.size() - 1)];
    const bool both =
        face_pair::derive(corners_m(first), corners_m(second), faces_[first], faces_[second]);
    sound = sound && both;
  }
  return sound;
}

/// REQUIRES: the faces of the edges' triangles are derived.
void TriangleMesh::derive_edges(std::span<const std::uint32_t> numbers) {
  // Use local pointers, because compilers can't exclude that writing the results changes these
  // members.
  const Vec3* const vertices_m = vertices_m_.data();
  const MeshFace* const faces = faces_.data();
  MeshEdge* const edges = edges_.data();
  flat_changes_.clear();
  for (const std::uint32_t number : numbers) {
    MeshEdge& edge = edges[number];
    const Vec3 start_m = vertices_m[edge.vertex[0]];
    const Vec3 along = vertices_m[edge.vertex[1]] - start_m;
    const double length_m = norm(along);
    const Vec3 normal = faces[edge.triangle[0]].normal;
    edge.start_m = start_m;
    edge.length_m = length_m;
    edge.direction = along / length_m;
    edge.normal[0] = normal;
    EdgeKind kind = EdgeKind::boundary;
    if (edge.triangle[1] != k_no_triangle) {
      const MeshFace& right = faces[edge.triangle[1]];
      edge.normal[1] = right.normal;
      // How far the right face rises above the left face's plane, per unit of distance from the
      // edge.
      const double rise = dot(normal, right.inward[edge.side[1]]);
      if (rise < -k_mesh_flat_sine) {
        kind = EdgeKind::convex;
      } else if (rise > k_mesh_flat_sine) {
        kind = EdgeKind::concave;
      } else {
        // Two faces back to back form the sharpest possible edge.
        kind = dot(normal, right.normal) < 0 ? EdgeKind::convex : EdgeKind::flat;
      }
    }
    const EdgeKind before = edge.kind;
    if (kind == before) continue;
    edge.kind = kind;
    count_edge(edge, before);
    if (kind == EdgeKind::flat || before == EdgeKind::flat) flat_changes_.push_back(number);
  }
}

/// Updates the counts at an edge's ends after its kind may have changed.
void TriangleMesh::count_edge(const MeshEdge& edge, EdgeKind before) {
  const auto exposes = [](EdgeKind kind) -> std::uint32_t {
    return kind == EdgeKind::convex || kind == EdgeKind::boundary ? 1 : 0;
  };
  for (const std::uint32_t v : edge.vertex)
    exposing_edges_[v] += exposes(edge.kind) - exposes(before);
}

/// Finds the triangles that have a moving vertex, these triangles' edges, and the edges' ends.
void TriangleMesh::find_moved(std::span<const VertexMove> moves) {
  // A world usually moves the same vertices each time, or only a few vertices.
  if (std::ranges::equal(moves, moves_of_, {}, &VertexMove::vertex)) return;
  is_moved_.resize(std::max({triangles_.size(), edges_.size(), vertices_m_.size()}));
  const auto add_once = [&](std::uint32_t item, std::vector<std::uint32_t>& items) {
    if (is_moved_[item] != 0) return;
    is_moved_[item] = 1;
    items.push_back(item);
  };
  const auto unmark = [&](const std::vector<std::uint32_t>& items) {
    for (const std::uint32_t item : items)
      is_moved_[item] = 0;
  };
  moves_of_.clear();
  moved_triangles_.clear();
  moved_edges_.clear();
  moved_vertices_.clear();
  for (const VertexMove& move : moves) {
    moves_of_.push_back(move.vertex);
    for (std::size_t i = triangles_first_[move.vertex];
         i < triangles_first_[move.vertex + std::size_t{1}]; ++i)
      add_once(triangles_about_[i], moved_triangles_);
  }
  unmark(moved_triangles_);
  for (const std::uint32_t t : moved_triangles_) {
    for (const std::uint32_t e : triangle_edges_[t])
      add_once(e, moved_edges_);
  }
  unmark(moved_edges_);
  for (const std::uint32_t e : moved_edges_) {
    for (const std::uint32_t v : edges_[e].vertex)
      add_once(v, moved_vertices_);
  }
  unmark(moved_vertices_);
}

/// Returns what is wrong with the vertices' present positions. REQUIRES: something is wrong.
MeshError TriangleMesh::error_of_move(std::span<const VertexMove> moves) const {
  std::optional<MeshError> error;
  for (const std::uint32_t t : moved_triangles_) {
    if (error && error->triangle < t) continue;
    if (const auto wrong = check_triangle(t)) error = wrong;
  }
  for (const VertexMove& move : moves) {
    if (!error && !finite(vertices_m_[move.vertex]))
      error = MeshError{.kind = MeshError::Kind::vertex_not_finite, .vertex = move.vertex};
  }
  CHECK(error.has_value());
  return *error;
}

std::optional<MeshError> TriangleMesh::move_vertices(std::span<const VertexMove> moves) {
  for (const VertexMove& move : moves)
    CHECK_LT(move.vertex, vertices_m_.size());
  find_moved(moves);
  flat_changes_.clear();
  old_positions_m_.clear();
  bool sound = true;
  for (const VertexMove& move : moves) {
    old_positions_m_.push_back(vertices_m_[move.vertex]);
    vertices_m_[move.vertex] = move.position_m;
  }
  for (const VertexMove& move : moves)
    sound = sound && finite(vertices_m_[move.vertex]);
  // Deriving faces also checks them. On failure, restore positions and derive the faces again.
  // Restore in reverse order, because a vertex may occur twice.
  if (!derive_faces(moved_triangles_) || !sound) {
    const MeshError error = error_of_move(moves);
    for (std::size_t i = moves.size(); i-- > 0;)
      vertices_m_[moves[i].vertex] = old_positions_m_[i];
    derive_faces(moved_triangles_);
    moves_of_.clear();
    moved_triangles_.clear();
    moved_edges_.clear();
    moved_vertices_.clear();
    return error;
  }
  derive_edges(moved_edges_);
  return std::nullopt;
}

std::string describe(const MeshError& error) {
  using Kind = MeshError::Kind;
  switch (error.kind) {
    case Kind::vertex_not_finite:
      if (error.triangle == k_no_triangle)
        return fmt::format("a coordinate of vertex {} is not a finite number", error.vertex);
      return fmt::format("triangle {}: a coordinate of vertex {} is not a finite number",
                         error.triangle, error.vertex);
    case Kind::index_out_of_range:
      return fmt::format("triangle {}: vertex {} does not exist", error.triangle, error.vertex);
    case Kind::degenerate_triangle:
      return fmt::format("triangle {} has no area: its height is below {:g} times its longest side",
                         error.triangle, k_mesh_sliver);
    case Kind::edge_shared_by_three:
      return fmt::format(
          "triangle {} shares an edge with triangle {} (at vertex {}), but that edge already has "
          "two triangles",
          error.triangle, error.other, error.vertex);
    case Kind::edge_run_twice:
      return fmt::format(
          "triangles {} and {} traverse their common edge (at vertex {}) in the same direction, so "
          "one triangle is inside out",
          error.other, error.triangle, error.vertex);
    case Kind::not_closed:
      return fmt::format(
          "the mesh is not closed: an edge of triangle {} (at vertex {}) has no second triangle",
          error.triangle, error.vertex);
  }
  return "unknown mesh error";
}

}  // namespace sleight::physics
