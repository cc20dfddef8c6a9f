// Goal: a mesh has the right features, and an invalid mesh gives an error that names the triangle.
// After vertices move, a mesh equals a new mesh with these vertices. Method: test a cube, a hollow
// and a sheet, which together have every kind of edge. Move random vertices of a grid up and down
// many times, and compare the mesh with a new mesh bit for bit.
#include "worker/physics/shape/triangle_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "common/random/stream.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;
using Kind = MeshError::Kind;
using Triangles = std::vector<TriangleCorners>;

struct Raw {
  std::vector<Vec3> vertices;
  Triangles triangles;
  auto build(MeshClosure closure) const { return TriangleMesh::make(vertices, triangles, closure); }
};

Raw triangulated(const ConvexPolyhedron& p) {
  Raw raw{.vertices = {p.vertices_m().begin(), p.vertices_m().end()}, .triangles = {}};
  for (const Face& face : p.faces()) {
    const auto sides = p.sides_of(face);
    for (std::size_t i = 1; i + 1 < sides.size(); ++i)
      raw.triangles.push_back({sides[0].vertex, sides[i].vertex, sides[i + 1].vertex});
  }
  return raw;
}

// A sheet of n x n squares at z = 0. Each square has two triangles, which face up.
Raw sheet(std::uint32_t n) {
  Raw raw;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x)
      raw.vertices.emplace_back(x, y, 0);
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t at = y * (n + 1) + x;
      raw.triangles.push_back({at, at + 1, at + n + 2});
      raw.triangles.push_back({at, at + n + 2, at + n + 1});
    }
  }
  return raw;
}

std::size_t count(const TriangleMesh& mesh, EdgeKind kind) {
  return static_cast<std::size_t>(std::count_if(mesh.edges().begin(), mesh.edges().end(),
                                                [&](const MeshEdge& e) { return e.kind == kind; }));
}

TEST(TriangleMesh, derives_the_features_of_a_cube) {
  const ConvexPolyhedron solid = cube(2).value();
  Raw raw = triangulated(solid);
  const TriangleMesh mesh = raw.build(MeshClosure::closed).value();
  EXPECT_EQ(mesh.edges().size(), 18U);
  EXPECT_EQ(count(mesh, EdgeKind::convex), 12U);
  EXPECT_EQ(count(mesh, EdgeKind::flat), 6U);
  for (std::uint32_t v = 0; v < 8; ++v)
    EXPECT_TRUE(mesh.exposed(v));
  for (std::uint32_t t = 0; t < 12; ++t) {
    const MeshFace& face = mesh.faces()[t];
    EXPECT_EQ(face.offset_m, 1);
    const TriangleCorners& corners = mesh.triangles()[t];
    const Vec3 middle =
        (raw.vertices[corners[0]] + raw.vertices[corners[1]] + raw.vertices[corners[2]]) / 3;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_GT(dot(face.inward[k], middle), face.inward_offset_m[k]);
      EXPECT_NEAR(norm(face.inward[k]), 1, 1e-15);
      const MeshEdge& edge = mesh.edges()[mesh.edges_of(t)[k]];
      const bool left = edge.triangle[0] == t;
      EXPECT_EQ(edge.vertex[left ? 0 : 1], corners[k]);
      EXPECT_EQ(edge.vertex[left ? 1 : 0], corners[(k + 1) % 3]);
      EXPECT_EQ(edge.normal[left ? 0 : 1], face.normal);
      EXPECT_NEAR(
          norm(edge.start_m + edge.length_m * edge.direction - raw.vertices[edge.vertex[1]]), 0,
          1e-15);
    }
  }
  // The same cube as a hollow: its edges are concave, and none is exposed.
  for (TriangleCorners& corners : raw.triangles)
    std::swap(corners[0], corners[1]);
  const TriangleMesh hollow = raw.build(MeshClosure::closed).value();
  EXPECT_EQ(count(hollow, EdgeKind::concave), 12U);
  for (std::uint32_t v = 0; v < 8; ++v)
    EXPECT_FALSE(hollow.exposed(v));
}

TEST(TriangleMesh, marks_boundaries_and_folds) {
  const TriangleMesh flat = sheet(3).build(MeshClosure::may_be_open).value();
  EXPECT_EQ(count(flat, EdgeKind::boundary), 12U);
  EXPECT_EQ(count(flat, EdgeKind::flat), flat.edges().size() - 12);
  EXPECT_TRUE(flat.exposed(0));
  EXPECT_FALSE(flat.exposed(5));
  // Two triangles back to back: three maximally convex edges.
  const Raw fold{.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                 .triangles = {{0, 1, 2}, {0, 2, 1}}};
  EXPECT_EQ(count(fold.build(MeshClosure::closed).value(), EdgeKind::convex), 3U);
}

void expect_equal(const TriangleMesh& a, const TriangleMesh& b) {
  ASSERT_TRUE(std::equal(a.vertices_m().begin(), a.vertices_m().end(), b.vertices_m().begin()));
  ASSERT_TRUE(std::equal(a.faces().begin(), a.faces().end(), b.faces().begin()));
  ASSERT_TRUE(std::equal(a.edges().begin(), a.edges().end(), b.edges().begin()));
  for (std::uint32_t v = 0; v < a.vertices_m().size(); ++v)
    ASSERT_EQ(a.exposed(v), b.exposed(v));
}

TEST(TriangleMesh, moved_equals_built_bit_for_bit) {
  random::Stream stream({.seed = 21, .purpose = random::Purpose::prior}, 0);
  Raw raw = sheet(8);
  TriangleMesh mesh = raw.build(MeshClosure::may_be_open).value();
  const TriangleMesh at_first = mesh;
  for (int i = 0; i < 300; ++i) {
    std::vector<VertexMove> moves;
    for (auto k = stream.bits() % 6; k > 0; --k) {
      const auto v = static_cast<std::uint32_t>(stream.bits() % raw.vertices.size());
      Vec3 p = raw.vertices[v];
      p.z() = stream.bits() % 4 == 0 ? 0 : stream.uniform();
      moves.push_back({v, p});
      raw.vertices[v] = p;
    }
    ASSERT_FALSE(mesh.move_vertices(moves).has_value());
    ASSERT_NO_FATAL_FAILURE(expect_equal(mesh, raw.build(MeshClosure::may_be_open).value())) << i;
  }
  EXPECT_GT(count(mesh, EdgeKind::convex), 10U);
  EXPECT_GT(count(mesh, EdgeKind::concave), 10U);
  // Moving the vertices back restores the whole mesh. The comparison can fail.
  EXPECT_FALSE(std::equal(mesh.faces().begin(), mesh.faces().end(), at_first.faces().begin()));
  std::vector<VertexMove> home;
  for (std::uint32_t v = 0; v < raw.vertices.size(); ++v)
    home.push_back({v, at_first.vertices_m()[v]});
  ASSERT_FALSE(mesh.move_vertices(home).has_value());
  expect_equal(mesh, at_first);
}

// Computes a face by definition. Computes each number separately.
MeshFace plain_face(const Vec3& a, const Vec3& b, const Vec3& c) {
  MeshFace face;
  face.normal = math::normalized(cross(b - a, c - a));
  face.offset_m = dot(face.normal, a);
  const std::array<Vec3, 4> around{a, b, c, a};
  for (std::size_t k = 0; k < 3; ++k) {
    face.inward[k] = math::normalized(cross(face.normal, around[k + 1] - around[k]));
    face.inward_offset_m[k] = dot(face.inward[k], around[k]);
  }
  return face;
}

TEST(TriangleMesh, two_faces_at_once_have_the_bits_of_one_at_a_time) {
  // Goal: for any number of triangles, faces that are computed in vector registers have the same
  // bits as faces that are computed one at a time. Method: make sheets and balls with random
  // vertices, and move vertices. Some shapes are far from the origin. Compare faces and edges with
  // the plain computation before and after each move.
  random::Stream stream({.seed = 23, .purpose = random::Purpose::prior}, 0);
  const auto random_place = [&](double size) -> Vec3 {
    const double x = stream.uniform();
    const double y = stream.uniform();
    return size * Vec3(x, y, stream.uniform());
  };
  const auto expect_plain = [](const TriangleMesh& mesh) {
    const auto p = mesh.vertices_m();
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
      const auto [a, b, c] = mesh.triangles()[t];
      ASSERT_EQ(mesh.faces()[t], plain_face(p[a], p[b], p[c])) << t;
    }
    for (std::uint32_t e = 0; e < mesh.edges().size(); ++e) {
      const MeshEdge& edge = mesh.edges()[e];
      const Vec3 along = p[edge.vertex[1]] - p[edge.vertex[0]];
      ASSERT_EQ(edge.direction, math::normalized(along)) << e;
      ASSERT_EQ(edge.length_m, norm(along)) << e;
      for (std::size_t i = 0; i < 2 && edge.triangle[i] != k_no_triangle; ++i) {
        ASSERT_EQ(mesh.edges_of(edge.triangle[i])[edge.side[i]], e);
        ASSERT_EQ(edge.normal[i], mesh.faces()[edge.triangle[i]].normal) << e;
      }
    }
  };
  for (int i = 0; i < 40; ++i) {
    Raw raw = i % 2 == 0 ? sheet(static_cast<std::uint32_t>(1 + i / 2))
                         : triangulated(icosphere(1, 1).value());
    const Vec3 shift = random_place(i % 3 == 0 ? 0 : 100);
    for (Vec3& vertex : raw.vertices)
      vertex += shift + random_place(0.2);
    TriangleMesh mesh = raw.build(MeshClosure::may_be_open).value();
    ASSERT_NO_FATAL_FAILURE(expect_plain(mesh));
    for (int k = 0; k < 4; ++k) {
      const auto v = static_cast<std::uint32_t>(stream.bits() % raw.vertices.size());
      const std::vector<VertexMove> moves{{v, raw.vertices[v] + random_place(0.1)}};
      ASSERT_FALSE(mesh.move_vertices(moves));
      ASSERT_NO_FATAL_FAILURE(expect_plain(mesh));
    }
  }
}

TEST(TriangleMesh, a_face_that_is_too_thin_is_found_in_either_half) {
  // Goal: move_vertices() refuses a thin face exactly if a new mesh with this face is refused.
  // Either triangle of a pair may be too thin. Method: move each vertex of a sheet close to a side,
  // so that a triangle is slightly too thin or barely thick enough.
  const Raw raw = sheet(3);
  int refused = 0;
  for (std::uint32_t v = 0; v + 1 < raw.vertices.size(); ++v) {
    for (const double height : {0.99 * k_mesh_sliver, 1.01 * k_mesh_sliver, 0.0, 1e61}) {
      Raw moved = raw;
      moved.vertices[v] = raw.vertices[v + 1] + Vec3(-1e-5 * height, height, 0);
      TriangleMesh mesh = raw.build(MeshClosure::may_be_open).value();
      const auto error = mesh.move_vertices(std::vector<VertexMove>{{v, moved.vertices[v]}});
      const auto built = moved.build(MeshClosure::may_be_open);
      ASSERT_EQ(error.has_value(), !built.ok()) << v << ", " << height;
      if (error) {
        ++refused;
        ASSERT_EQ(*error, built.error());
        ASSERT_NO_FATAL_FAILURE(expect_equal(mesh, raw.build(MeshClosure::may_be_open).value()));
      } else {
        ASSERT_NO_FATAL_FAILURE(expect_equal(mesh, built.value()));
      }
    }
  }
  EXPECT_GT(refused, 30);
  EXPECT_LT(refused, 55);
}

TEST(TriangleMesh, a_move_lists_what_it_concerns) {
  // Goal: moved_triangles() lists the triangles around moved vertices, moved_edges() lists the
  // edges of these triangles, and moved_vertices() lists their corners. Each item is in its list
  // once. flat_changes() lists the edges that became flat or stopped being flat. After a refused
  // move, all lists are empty. Method: make random moves in a sheet and in a closed mesh; some move
  // a vertex twice. Compare the lists with a search through all triangles.
  random::Stream stream({.seed = 22, .purpose = random::Purpose::prior}, 0);
  const auto sorted = [](std::span<const std::uint32_t> items) {
    std::vector<std::uint32_t> list(items.begin(), items.end());
    std::sort(list.begin(), list.end());
    return list;
  };
  std::size_t changes = 0;
  for (const Raw& raw : {sheet(6), triangulated(icosphere(1, 1).value())}) {
    TriangleMesh mesh = raw.build(MeshClosure::may_be_open).value();
    for (int i = 0; i < 200; ++i) {
      std::vector<VertexMove> moves;
      std::set<std::uint32_t> moved;
      for (auto k = stream.bits() % 8; k > 0; --k) {
        const auto v = static_cast<std::uint32_t>(stream.bits() % raw.vertices.size());
        moved.insert(v);
        const double rise_m = stream.bits() % 2 == 0 ? 0 : 0.1 * stream.uniform();
        moves.push_back({v, raw.vertices[v] + Vec3(0, 0, rise_m)});
      }
      if (i % 5 == 0) {
        ASSERT_FALSE(mesh.move_vertices(moves));
      }
      const std::vector<MeshEdge> before(mesh.edges().begin(), mesh.edges().end());
      std::set<std::uint32_t> triangles;
      std::set<std::uint32_t> edges;
      std::set<std::uint32_t> ends;
      for (std::uint32_t t = 0; t < raw.triangles.size(); ++t) {
        if (std::ranges::none_of(raw.triangles[t], [&](auto v) { return moved.contains(v); }))
          continue;
        triangles.insert(t);
        edges.insert(mesh.edges_of(t).begin(), mesh.edges_of(t).end());
        ends.insert(raw.triangles[t].begin(), raw.triangles[t].end());
      }
      ASSERT_FALSE(mesh.move_vertices(moves));
      std::vector<std::uint32_t> changed;
      for (std::uint32_t e = 0; e < before.size(); ++e) {
        if ((before[e].kind == EdgeKind::flat) != (mesh.edges()[e].kind == EdgeKind::flat))
          changed.push_back(e);
      }
      changes += changed.size();
      ASSERT_EQ(sorted(mesh.moved_triangles()), std::vector(triangles.begin(), triangles.end()))
          << i;
      ASSERT_EQ(sorted(mesh.flat_changes()), changed) << i;
      ASSERT_EQ(sorted(mesh.moved_edges()), std::vector(edges.begin(), edges.end())) << i;
      ASSERT_EQ(sorted(mesh.moved_vertices()), std::vector(ends.begin(), ends.end())) << i;
    }
    const double nan = std::numeric_limits<double>::quiet_NaN();
    ASSERT_TRUE(mesh.move_vertices(std::vector<VertexMove>{{3, Vec3(0, 0, nan)}}));
    EXPECT_TRUE(mesh.moved_triangles().empty());
    EXPECT_TRUE(mesh.moved_edges().empty());
    EXPECT_TRUE(mesh.moved_vertices().empty());
    EXPECT_TRUE(mesh.flat_changes().empty());
  }
  EXPECT_GT(changes, 200U);
}

TEST(TriangleMesh, a_bad_move_changes_nothing_and_says_why) {
  TriangleMesh mesh = sheet(3).build(MeshClosure::may_be_open).value();
  const TriangleMesh before = mesh;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto not_finite =
      mesh.move_vertices(std::vector<VertexMove>{{5, Vec3(1, 1, 1)}, {6, Vec3(0, nan, 0)}});
  ASSERT_TRUE(not_finite.has_value());
  EXPECT_EQ(not_finite->kind, Kind::vertex_not_finite);
  EXPECT_EQ(not_finite->vertex, 6U);
  EXPECT_EQ(not_finite->triangle, 2U);
  // Move vertex 5 onto its neighbour 6, after a detour. Triangle 2 is the first triangle without
  // area.
  const auto flat =
      mesh.move_vertices(std::vector<VertexMove>{{5, Vec3(0, 0, 5)}, {5, Vec3(2, 1, 0)}});
  ASSERT_TRUE(flat.has_value());
  EXPECT_EQ(flat->kind, Kind::degenerate_triangle);
  expect_equal(mesh, before);
}

TEST(TriangleMesh, refuses_and_names_the_triangle) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error_of = [](const Raw& raw, MeshClosure closure = MeshClosure::may_be_open) {
    const auto mesh = raw.build(closure);
    EXPECT_FALSE(mesh.ok());
    EXPECT_FALSE(describe(mesh.error()).empty());
    return mesh.error();
  };
  Raw raw = sheet(2);
  raw.vertices[8].x() = nan;
  EXPECT_EQ(error_of(raw), (MeshError{Kind::vertex_not_finite, 6, k_no_triangle, 8}));
  raw = sheet(2);
  raw.vertices.emplace_back(nan, 0, 0);
  EXPECT_EQ(error_of(raw), (MeshError{Kind::vertex_not_finite, k_no_triangle, k_no_triangle, 9}));
  raw = sheet(2);
  raw.triangles[3][1] = 9;
  EXPECT_EQ(error_of(raw), (MeshError{Kind::index_out_of_range, 3, k_no_triangle, 9}));
  raw = sheet(2);
  raw.triangles[5][1] = raw.triangles[5][0];
  EXPECT_EQ(error_of(raw).kind, Kind::degenerate_triangle);
  EXPECT_EQ(error_of(raw).triangle, 5U);
  raw = sheet(2);
  std::swap(raw.triangles[1][0], raw.triangles[1][1]);
  EXPECT_EQ(error_of(raw).kind, Kind::edge_run_twice);
  EXPECT_EQ(error_of(raw).triangle, 1U);
  EXPECT_EQ(error_of(raw).other, 0U);
  raw = sheet(2);
  raw.vertices.emplace_back(0, 0, 1);
  raw.triangles.push_back({0, 4, 9});
  EXPECT_EQ(error_of(raw).kind, Kind::edge_shared_by_three);
  EXPECT_EQ(error_of(raw).triangle, 8U);
  EXPECT_EQ(error_of(sheet(2), MeshClosure::closed).kind, Kind::not_closed);
}

}  // namespace
}  // namespace sleight::physics
