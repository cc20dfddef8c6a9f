#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/round_piece.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

constexpr std::size_t k_pad = 4;

// Newell's formula (Sutherland, Sproull and Schumacker 1974, "A characterization of ten
// hidden-surface algorithms"). Vertices are taken relative to the first one, so that shapes far
// from the origin lose no digits.
Vec3 loop_normal(std::span<const Vec3> vertices_m, std::span<const std::uint16_t> loop) {
  const Vec3 origin = vertices_m[loop[0]];
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    const Vec3 a = vertices_m[loop[i]] - origin;
    const Vec3 b = vertices_m[loop[i + 1]] - origin;
    sum += cross(a, b);
  }
  return math::normalized(sum);
}

}  // namespace

struct ConvexPolyhedron::DirectedEdge {
  std::uint16_t from, to;
  std::uint16_t face, side;
};

ConvexPolyhedron polyhedron_of_loops(std::span<const Vec3> vertices_m,
                                     std::span<const std::vector<std::uint16_t>> loops) {
  ConvexPolyhedron result;
  result.vertices_m_.assign(vertices_m.begin(), vertices_m.end());
  std::vector<ConvexPolyhedron::DirectedEdge> directed;
  result.r_inner_m_ = std::numeric_limits<double>::infinity();
  for (const auto& loop : loops)
    result.add_face(loop, directed);
  result.join_sides(directed);
  result.index_rings();
  result.index_axes();
  return result;
}

void ConvexPolyhedron::add_face(std::span<const std::uint16_t> loop,
                                std::vector<DirectedEdge>& directed) {
  CHECK_GE(loop.size(), 3U);
  Face face;
  face.normal = loop_normal(vertices_m_, loop);
  face.offset_m = -std::numeric_limits<double>::infinity();
  face.first_side = static_cast<std::uint16_t>(sides_.size());
  face.side_count = static_cast<std::uint16_t>(loop.size());
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::uint16_t from = loop[i];
    const std::uint16_t to = loop[i + 1 == loop.size() ? 0 : i + 1];
    const Vec3 along = vertices_m_[to] - vertices_m_[from];
    Side side;
    side.inward = math::normalized(cross(face.normal, along));
    side.offset_m = dot(side.inward, vertices_m_[from]);
    side.vertex = from;
    directed.push_back({from, to, static_cast<std::uint16_t>(faces_.size()),
                        static_cast<std::uint16_t>(sides_.size())});
    sides_.push_back(side);
    face.offset_m = std::max(face.offset_m, dot(face.normal, vertices_m_[from]));
  }
  r_inner_m_ = std::min(r_inner_m_, face.offset_m);
  faces_.push_back(face);
}

void ConvexPolyhedron::join_sides(std::vector<DirectedEdge>& directed) {
  // Sort by the lower, then the higher vertex, so that opposite sides are neighbours.
  std::sort(directed.begin(), directed.end(), [](const DirectedEdge& a, const DirectedEdge& b) {
    const auto low_a = std::min(a.from, a.to), low_b = std::min(b.from, b.to);
    const auto high_a = std::max(a.from, a.to), high_b = std::max(b.from, b.to);
    if (low_a != low_b) return low_a < low_b;
    if (high_a != high_b) return high_a < high_b;
    return a.from < b.from;
  });
  CHECK_EQ(directed.size() % 2, 0U);
  for (std::size_t i = 0; i < directed.size(); i += 2) {
    const DirectedEdge& left = directed[i];
    const DirectedEdge& right = directed[i + 1];
    CHECK(left.from == right.to && left.to == right.from && left.face != right.face);
    const auto index = static_cast<std::uint16_t>(edges_.size());
    edges_.push_back({.vertex = {left.from, left.to},
                      .face = {left.face, right.face},
                      .side = {left.side, right.side}});
    sides_[left.side].edge = index;
    sides_[right.side].edge = index;
  }
}

void ConvexPolyhedron::index_axes() {
  Vec3 sum = Vec3::Zero();
  double square = 0;
  for (const Vec3& v : vertices_m_) {
    sum += v;
    square = std::max(square, dot(v, v));
  }
  centre_m_ = sum / static_cast<double>(vertices_m_.size());
  r_outer_m_ = std::sqrt(square);
  const std::size_t padded = (vertices_m_.size() + k_pad - 1) / k_pad * k_pad;
  by_axis_m_.resize(3 * padded);
  for (std::size_t i = 0; i < padded; ++i) {
    const Vec3& v = vertices_m_[i < vertices_m_.size() ? i : 0];
    by_axis_m_[i] = v.x();
    by_axis_m_[padded + i] = v.y();
    by_axis_m_[2 * padded + i] = v.z();
  }
}

void ConvexPolyhedron::index_rings() {
  struct Spoke {
    std::uint16_t from, to, edge;
  };
  std::vector<Spoke> spokes;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const auto [a, b] = edges_[e].vertex;
    spokes.push_back({a, b, static_cast<std::uint16_t>(e)});
    spokes.push_back({b, a, static_cast<std::uint16_t>(e)});
  }
  std::sort(spokes.begin(), spokes.end(), [](const Spoke& a, const Spoke& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  });
  ring_first_.assign(vertices_m_.size() + 1, 0);
  for (const Spoke& spoke : spokes) {
    ++ring_first_[spoke.from + std::size_t{1}];
    ring_vertices_.push_back(spoke.to);
    ring_edges_.push_back(spoke.edge);
  }
  for (std::size_t v = 1; v < ring_first_.size(); ++v)
    ring_first_[v] = static_cast<std::uint16_t>(ring_first_[v] + ring_first_[v - 1]);
  // A vertex has as many faces as edges, so ring_first_ applies to both.
  ring_faces_.assign(ring_vertices_.size(), 0);
  std::vector<std::uint16_t> used(vertices_m_.size(), 0);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    for (const Side& side : sides_of(faces_[f])) {
      const std::size_t slot = std::size_t{ring_first_[side.vertex]} + used[side.vertex]++;
      CHECK_LT(slot, std::size_t{ring_first_[side.vertex + std::size_t{1}]});
      ring_faces_[slot] = static_cast<std::uint16_t>(f);
    }
  }
}

ConvexView ConvexPolyhedron::view() const {
  const std::size_t padded = by_axis_m_.size() / 3;
  return {.vertices_m = vertices_m_.data(),
          .xs_m = by_axis_m_.data(),
          .ys_m = by_axis_m_.data() + padded,
          .zs_m = by_axis_m_.data() + 2 * padded,
          .faces = faces_.data(),
          .sides = sides_.data(),
          .edges = edges_.data(),
          .ring_first = ring_first_.data(),
          .ring_vertices = ring_vertices_.data(),
          .ring_edges = ring_edges_.data(),
          .ring_faces = ring_faces_.data(),
          .vertex_count = static_cast<std::uint16_t>(vertices_m_.size()),
          .face_count = static_cast<std::uint16_t>(faces_.size()),
          .edge_count = static_cast<std::uint16_t>(edges_.size()),
          .padded_count = static_cast<std::uint16_t>(padded),
          .r_outer_m = r_outer_m_,
          .centre_m = centre_m_};
}

ConvexPolyhedron moved(const ConvexPolyhedron& polyhedron, const Mat3& rotation,
                       const Vec3& shift_m) {
  std::vector<Vec3> vertices_m;
  for (const Vec3& v : polyhedron.vertices_m()) {
    const Vec3 turned = math::product(rotation, v);
    vertices_m.emplace_back(turned + shift_m);
  }
  std::vector<std::vector<std::uint16_t>> loops;
  for (const Face& face : polyhedron.faces()) {
    auto& loop = loops.emplace_back();
    for (const Side& side : polyhedron.sides_of(face))
      loop.push_back(side.vertex);
  }
  return polyhedron_of_loops(vertices_m, loops);
}

std::string describe(const ShapeError& error) {
  using Kind = ShapeError::Kind;
  switch (error.kind) {
    case Kind::too_few_points:
      return fmt::format("a solid needs at least 4 points, found {}", error.index);
    case Kind::too_many_points:
      return fmt::format("at most {} points are allowed, found {}", k_hull_points_max, error.index);
    case Kind::not_finite:
      return fmt::format("a coordinate of point {} is not a finite number", error.index);
    case Kind::flat:
      return fmt::format(
          "the points are nearly coplanar: their thickness is {:.3g} times their extent, expected "
          "at least {:g} times",
          error.measured, k_hull_flat);
    case Kind::degenerate:
      return "some features of the points' hull are as small as its tolerance";
    case Kind::not_spherical:
      return fmt::format(
          "the body is declared spherical, but the relative difference of the moments of inertia "
          "is {:.3g}",
          error.measured);
    case Kind::not_axial:
      return fmt::format(
          "the body is declared axial, but no two moments of inertia are equal; the smallest "
          "relative difference is {:.3g}",
          error.measured);
    case Kind::no_parts:
      return "a body needs at least one part";
    case Kind::dimension_not_positive:
      return fmt::format("number {} (a size, density or count) must be positive and finite",
                         error.index);
    case Kind::too_many_features:
      return fmt::format("at most {} rings and balls are allowed, found {}", k_round_features_max,
                         error.index);
    case Kind::no_axis:
      return "a round piece needs an axis of length 1 and a finite origin";
    case Kind::sharp:
      return fmt::format(
          "the radius of ring or ball {} is {:.3g} of the piece's size, expected at least {:g}",
          error.index, error.measured, k_round_edge_min);
  }
  return "unknown shape error";
}

}  // namespace sleight::physics
