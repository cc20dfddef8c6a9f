#include "worker/physics/shape/small_pieces.h"

#include <algorithm>
#include <cmath>

namespace sleight::physics {
namespace {

// The topology of every triangle. Edge i joins corners i and i + 1. Sides 0 to 2 belong to face 0,
// in this order. Sides 3 to 5 belong to face 1, whose corners run 0, 2, 1.
constexpr std::array<Edge, 3> k_edges{Edge{.vertex = {0, 1}, .face = {0, 1}, .side = {0, 5}},
                                      Edge{.vertex = {1, 2}, .face = {0, 1}, .side = {1, 4}},
                                      Edge{.vertex = {2, 0}, .face = {0, 1}, .side = {2, 3}}};
constexpr std::array<std::uint16_t, 4> k_ring_first{0, 2, 4, 6};
constexpr std::array<std::uint16_t, 6> k_ring_vertices{1, 2, 0, 2, 0, 1};
constexpr std::array<std::uint16_t, 6> k_ring_edges{0, 2, 0, 1, 2, 1};
constexpr std::array<std::uint16_t, 6> k_ring_faces{0, 1, 0, 1, 0, 1};
constexpr std::array<std::uint16_t, 2> k_no_ring{0, 0};

}  // namespace

TrianglePiece::TrianglePiece(const Vec3& a_m, const Vec3& b_m, const Vec3& c_m)
    : vertices_m_{a_m, b_m, c_m} {
  const Vec3 normal = math::normalized(math::cross(b_m - a_m, c_m - a_m));
  const double offset_m = math::dot(normal, a_m);
  faces_[0] = {.normal = normal, .offset_m = offset_m, .first_side = 0, .side_count = 3};
  faces_[1] = {.normal = -normal, .offset_m = -offset_m, .first_side = 3, .side_count = 3};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& from = vertices_m_[i];
    const Vec3& to = vertices_m_[(i + 1) % 3];
    Side side;
    side.inward = math::normalized(math::cross(normal, to - from));
    side.offset_m = math::dot(side.inward, from);
    side.vertex = static_cast<std::uint16_t>(i);
    side.edge = static_cast<std::uint16_t>(i);
    sides_[i] = side;
    // The other face has the same side in the opposite direction.
    side.vertex = static_cast<std::uint16_t>((i + 1) % 3);
    sides_[5 - i] = side;
    r_outer_m_ = std::max(r_outer_m_, math::norm(from));
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3& v = vertices_m_[i % 3];
    by_axis_m_[0][i] = v.x();
    by_axis_m_[1][i] = v.y();
    by_axis_m_[2][i] = v.z();
  }
  centre_m_ = (a_m + b_m + c_m) / 3;
}

ConvexView TrianglePiece::view() const {
  return {.vertices_m = vertices_m_.data(),
          .xs_m = by_axis_m_[0].data(),
          .ys_m = by_axis_m_[1].data(),
          .zs_m = by_axis_m_[2].data(),
          .faces = faces_.data(),
          .sides = sides_.data(),
          .edges = k_edges.data(),
          .ring_first = k_ring_first.data(),
          .ring_vertices = k_ring_vertices.data(),
          .ring_edges = k_ring_edges.data(),
          .ring_faces = k_ring_faces.data(),
          .vertex_count = 3,
          .face_count = 2,
          .edge_count = 3,
          .padded_count = 4,
          .r_outer_m = r_outer_m_,
          .centre_m = centre_m_};
}

PointPiece::PointPiece(const Vec3& point_m) : point_m_(point_m) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    by_axis_m_[axis].fill(point_m[static_cast<Eigen::Index>(axis)]);
}

ConvexView PointPiece::view() const {
  return {.vertices_m = &point_m_,
          .xs_m = by_axis_m_[0].data(),
          .ys_m = by_axis_m_[1].data(),
          .zs_m = by_axis_m_[2].data(),
          .ring_first = k_no_ring.data(),
          .vertex_count = 1,
          .padded_count = 4,
          .r_outer_m = math::norm(point_m_),
          .centre_m = point_m_};
}

}  // namespace sleight::physics
