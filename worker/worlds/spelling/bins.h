// The geometry of the box of bins (thesis A.2.1, figure A.1).
//
// Frame: the origin is in the middle of the box on the floor's rim. The x axis points right, from
// column to column. The y axis points towards a pattern's row 0. The z axis points up.
//
// Idea. Floor domes, partition sides and partition tops form one closed surface, so bodies can't
// meet the surface from inside or meet an edge twice. Where two partitions cross, their tops have
// four corners. Each corner is a separate vertex (a "partition vertex"). If a crossing had only one
// vertex, the tops would always be level across, and balls would stay on them. A partition that
// meets the box's wall ends in two vertices, half a thickness inside the wall's inner face. The
// walls are blocks around the box.
//
// Invariants
//   1. Vertices 0 to vertex_count() - 1 of the mesh are the partition vertices. Crossings are
//      ordered row by row from the lowest y and x. Corners within a crossing have the same order.
// Thread safety: const after construction.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/math/vector.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/shape/triangle_mesh.h"
#include "worker/worlds/spelling/parameters.h"

namespace sleight::worlds::spelling {

using math::Vec2;
using math::Vec3;

inline constexpr std::uint32_t k_no_vertex = UINT32_MAX;

/// A bin, counted from the lowest x and y.
struct Bin {
  std::uint32_t column = 0;
  std::uint32_t row = 0;
  friend bool operator==(const Bin&, const Bin&) = default;
};

class Bins {
 public:
  /// REQUIRES: sizes > 0; at least one column and one row.
  Bins(const WorldParameters& world, std::uint32_t columns, std::uint32_t rows);

  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  std::uint32_t vertex_count() const { return vertex_count_; }
  /// Returns the partition vertices without offsets.
  std::span<const Vec3> vertices_m() const {
    return std::span(mesh_->vertices_m()).first(vertex_count_);
  }
  /// Distance between the middles of neighbouring bins.
  double pitch_m() const { return pitch_m_; }
  /// Half of the box's length and width, measured between its walls.
  const Vec2& half_m() const { return half_m_; }
  /// Returns the bin at a place's x and y, or nothing if the place is outside the box. The middle
  /// of a partition belongs to the bin with the larger coordinates.
  std::optional<Bin> bin_at(const Vec3& place_m) const;
  Vec3 floor_middle_m(const Bin& bin) const;
  /// Returns the partition vertices at a bin's corners; k_no_vertex at a corner of the box.
  const std::array<std::uint32_t, 4>& corners(const Bin& bin) const {
    return corners_[std::size_t{bin.row} * columns_ + bin.column];
  }

  /// Returns the surface with moved partition vertices. If the offsets turn the surface inside out,
  /// returns nothing.
  std::shared_ptr<const physics::TriangleMesh> surface(std::span<const Vec3> offsets_m) const;
  /// Returns a copy of the surface without offsets.
  std::shared_ptr<physics::TriangleMesh> unmoved_surface() const {
    return std::make_shared<physics::TriangleMesh>(*mesh_);
  }
  std::span<const physics::StaticConvex> walls() const { return walls_; }
  /// Returns the plane on which the box stands. The plane is at the walls' lower end.
  physics::StaticPlane ground() const;

 private:
  struct Builder;

  double pitch_m_;
  std::uint32_t columns_;
  std::uint32_t rows_;
  std::uint32_t vertex_count_ = 0;
  Vec2 half_m_{0, 0};
  std::vector<std::array<std::uint32_t, 4>> corners_;  ///< by bin
  std::shared_ptr<const physics::TriangleMesh> mesh_;
  std::vector<physics::StaticConvex> walls_;
};

}  // namespace sleight::worlds::spelling
