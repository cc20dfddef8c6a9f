// Random triangle meshes: sheets and stars.
//
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "common/random/stream.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/shape/triangle_mesh.h"

namespace sleight::physics::testing {

inline Vec3 vector_between(random::Stream& stream, double low, double high) {
  Vec3 v;
  for (int i = 0; i < 3; ++i)
    v[i] = low + (high - low) * stream.uniform();
  return v;
}

struct Raw {
  std::vector<Vec3> vertices_m;
  std::vector<TriangleCorners> triangles;
};

/// n x n squares at heights up to `high_m`. A third of the vertices are at height 0, and the
/// squares' diagonals vary.
inline Raw sheet(std::uint32_t n, double edge_m, double high_m, random::Stream& stream) {
  Raw raw;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      const double height_m = stream.bits() % 3 == 0 ? 0 : high_m * stream.uniform();
      raw.vertices_m.emplace_back(edge_m * x, edge_m * y, height_m);
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = y * (n + 1) + x;
      const std::uint32_t b = a + n + 1;
      if (stream.bits() % 2 == 0) {
        raw.triangles.insert(raw.triangles.end(), {{a, a + 1, b + 1}, {a, b + 1, b}});
      } else {
        raw.triangles.insert(raw.triangles.end(), {{a, a + 1, b}, {a + 1, b + 1, b}});
      }
    }
  }
  return raw;
}

/// A closed ball of triangles. The corners are moved in and out, so the ball has edges of every
/// kind.
inline Raw star(random::Stream& stream, double roughness) {
  const ConvexPolyhedron ball = icosphere(1, 1).value();
  Raw raw;
  for (const Vec3& v : ball.vertices_m())
    raw.vertices_m.push_back((1 - roughness * stream.uniform()) * v);
  for (const Face& face : ball.faces()) {
    const auto sides = ball.sides_of(face);
    for (std::size_t i = 1; i + 1 < sides.size(); ++i)
      raw.triangles.push_back({sides[0].vertex, sides[i].vertex, sides[i + 1].vertex});
  }
  return raw;
}

inline std::shared_ptr<const TriangleMesh> mesh_of(const Raw& raw, MeshClosure closure) {
  return std::make_shared<const TriangleMesh>(
      TriangleMesh::make(raw.vertices_m, raw.triangles, closure).value());
}

inline std::shared_ptr<const TriangleMesh> open_mesh(const Raw& raw) {
  return mesh_of(raw, MeshClosure::may_be_open);
}

}  // namespace sleight::physics::testing
