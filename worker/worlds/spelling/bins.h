// The box of bins: its geometry, and where in it a place is (thesis A.2.1, figure A.1).
//
// Frame: the origin in the middle of the box on the floor's rim, x along the columns to the right,
// y along the rows upwards (row 0 of a pattern is at the largest y), z up.
//
// Idea. Floor domes, partition sides and partition tops are one closed surface, so that nothing can
// be met from inside and no edge twice. The four corners of the partitions' tops at a crossing of
// two are vertices of their own ("partition vertices"): with one for each crossing tops would stay
// level across and balls would perch on them. Where a partition runs into the box's wall it ends in
// two, half a thickness inside of that. Walls are blocks about all.
//
// Invariants
//   1. Vertices 0 to vertex_count() - 1 of the mesh are the partition vertices, in the order of
//      crossings, row by row from the lowest y and x, and at each of their corners likewise.
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
  /// Partition vertices, each with an offset of its own.
  std::uint32_t vertex_count() const { return vertex_count_; }
  /// Without an offset.
  std::span<const Vec3> vertices_m() const {
    return std::span(mesh_->vertices_m()).first(vertex_count_);
  }
  /// From the middle of a bin to that of the next.
  double pitch_m() const { return pitch_m_; }
  /// Half the sides of the box inside its walls.
  const Vec2& half_m() const { return half_m_; }
  /// The bin below or above a place; nothing outside of the box. On the middle of a partition it is
  /// the one at larger coordinates.
  std::optional<Bin> bin_at(const Vec3& place_m) const;
  Vec3 floor_middle_m(const Bin& bin) const;
  /// The partition vertices at a bin's corners; k_no_vertex in a corner of the box.
  const std::array<std::uint32_t, 4>& corners(const Bin& bin) const {
    return corners_[std::size_t{bin.row} * columns_ + bin.column];
  }

  /// The surface with its partition vertices moved. Nothing if the offsets turn it inside out.
  std::shared_ptr<const physics::TriangleMesh> surface(std::span<const Vec3> offsets_m) const;
  /// A copy of the surface, without offsets.
  std::shared_ptr<physics::TriangleMesh> unmoved_surface() const {
    return std::make_shared<physics::TriangleMesh>(*mesh_);
  }
  /// The walls of the box.
  std::span<const physics::StaticConvex> walls() const { return walls_; }
  /// What the box stands on, at the lower end of its walls.
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
