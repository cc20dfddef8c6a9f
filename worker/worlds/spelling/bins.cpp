#include "worker/worlds/spelling/bins.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/base/check.h"
#include "worker/physics/shape/convex_polyhedron.h"

namespace sleight::worlds::spelling {
namespace {

/// Depth of the closed surface below the floor.
constexpr double k_below_m = 0.01;
constexpr double k_wall_m = 0.02;

physics::StaticConvex block(const char* name, const Vec3& low_m, const Vec3& high_m) {
  std::vector<Vec3> corners_m;
  for (int i = 0; i < 8; ++i) {
    corners_m.emplace_back((i & 1) != 0 ? high_m.x() : low_m.x(),
                           (i & 2) != 0 ? high_m.y() : low_m.y(),
                           (i & 4) != 0 ? high_m.z() : low_m.z());
  }
  return {.name = name,
          .polyhedron = std::make_shared<const physics::ConvexPolyhedron>(
              physics::convex_hull(corners_m).value())};
}

}  // namespace

/// Collects vertices and triangles. Lines run between bins and along the box's border. A crossing
/// is where two lines meet. There are columns + 1 column lines (i) and rows + 1 row lines (j).
struct Bins::Builder {
  const WorldParameters& world;
  const Bins& bins;
  std::vector<Vec3> vertices_m{};
  std::vector<physics::TriangleCorners> triangles{};
  std::map<std::array<std::uint32_t, 4>, std::uint32_t> tops{};  ///< by lines i, j and sides x, y

  double line_x_m(std::uint32_t i) const {
    return (static_cast<double>(i) - 0.5 * bins.columns_) * bins.pitch_m_;
  }
  double line_y_m(std::uint32_t j) const {
    return (static_cast<double>(j) - 0.5 * bins.rows_) * bins.pitch_m_;
  }
  bool inner_x(std::uint32_t i) const { return i > 0 && i < bins.columns_; }
  bool inner_y(std::uint32_t j) const { return j > 0 && j < bins.rows_; }

  std::uint32_t add(const Vec3& place_m) {
    vertices_m.push_back(place_m);
    return static_cast<std::uint32_t>(vertices_m.size() - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    triangles.push_back({a, b, c});
  }
  /// Corners are anticlockwise as seen from outside.
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }

  /// Adds the tops' corners. At the border, a partition ends in two vertices on the border's line.
  void add_partition_vertices() {
    const double half_m = 0.5 * world.partition_m;
    for (std::uint32_t j = 0; j <= bins.rows_; ++j) {
      for (std::uint32_t i = 0; i <= bins.columns_; ++i) {
        if (!inner_x(i) && !inner_y(j)) continue;
        for (std::uint32_t y = 0; y < (inner_y(j) ? 2U : 1U); ++y) {
          for (std::uint32_t x = 0; x < (inner_x(i) ? 2U : 1U); ++x) {
            const double shift_x_m = inner_x(i) ? (x == 0 ? -half_m : half_m) : 0;
            const double shift_y_m = inner_y(j) ? (y == 0 ? -half_m : half_m) : 0;
            tops[{i, j, x, y}] =
                add({line_x_m(i) + shift_x_m, line_y_m(j) + shift_y_m, world.partition_height_m});
          }
        }
      }
    }
  }
  /// Returns a crossing's corner. `x` and `y` tell the corner's side of each line. A border's line
  /// has only one side.
  std::uint32_t top(std::uint32_t i, std::uint32_t j, std::uint32_t x, std::uint32_t y) const {
    return tops.at({i, j, inner_x(i) ? x : 0, inner_y(j) ? y : 0});
  }

  /// Like top(), but returns k_no_vertex at a corner of the box.
  std::uint32_t corner(std::uint32_t i, std::uint32_t j, std::uint32_t x, std::uint32_t y) const {
    return inner_x(i) || inner_y(j) ? top(i, j, x, y) : k_no_vertex;
  }

  void add_tops() {
    for (std::uint32_t j = 0; j <= bins.rows_; ++j) {
      for (std::uint32_t i = 0; i <= bins.columns_; ++i) {
        if (inner_x(i) && inner_y(j))
          quad(top(i, j, 0, 0), top(i, j, 1, 0), top(i, j, 1, 1), top(i, j, 0, 1));
        if (inner_x(i) && j < bins.rows_)
          quad(top(i, j, 0, 1), top(i, j, 1, 1), top(i, j + 1, 1, 0), top(i, j + 1, 0, 0));
        if (inner_y(j) && i < bins.columns_)
          quad(top(i, j, 1, 0), top(i + 1, j, 0, 0), top(i + 1, j, 0, 1), top(i, j, 1, 1));
      }
    }
  }

  void add_bin(std::uint32_t i, std::uint32_t j) {
    const Vec3 middle_m = bins.floor_middle_m({i, j});
    const double half_m = 0.5 * world.bin_m;
    const auto rim = [&](double x, double y) {
      return add({middle_m.x() + x * half_m, middle_m.y() + y * half_m, 0});
    };
    const std::array<std::uint32_t, 4> rims{rim(-1, -1), rim(1, -1), rim(1, 1), rim(-1, 1)};
    const std::uint32_t apex = add(middle_m + Vec3(0, 0, world.dome_m));
    for (std::size_t k = 0; k < 4; ++k)
      triangle(rims[k], rims[(k + 1) % 4], apex);
    // Add the partitions' sides as seen from the bin.
    if (j > 0) quad(rims[1], rims[0], top(i, j, 1, 1), top(i + 1, j, 0, 1));
    if (i + 1 < bins.columns_) quad(rims[2], rims[1], top(i + 1, j, 0, 1), top(i + 1, j + 1, 0, 0));
    if (j + 1 < bins.rows_) quad(rims[3], rims[2], top(i + 1, j + 1, 0, 0), top(i, j + 1, 1, 0));
    if (i > 0) quad(rims[0], rims[3], top(i, j + 1, 1, 0), top(i, j, 1, 1));
  }

  /// Closes the surface from below with a skirt inside the walls and a bottom.
  void close_below() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, bool> edges;
    for (const auto& corners : triangles) {
      for (std::size_t k = 0; k < 3; ++k)
        edges[{corners[k], corners[(k + 1) % 3]}] = true;
    }
    std::map<std::uint32_t, std::uint32_t> below;
    const auto lowered = [&](std::uint32_t vertex) {
      const auto known = below.find(vertex);
      if (known != below.end()) return known->second;
      Vec3 place_m = vertices_m[vertex];
      for (int axis = 0; axis < 2; ++axis) {
        const double half_m = bins.half_m_[axis];
        if (std::fabs(place_m[axis]) > half_m - 0.1 * world.bin_m)
          place_m[axis] += std::copysign(0.25 * k_wall_m, place_m[axis]);
      }
      place_m.z() = -k_below_m;
      const std::uint32_t added = add(place_m);
      below[vertex] = added;
      return added;
    };
    // If the bottom vertex is in line with a partition's end, or nearly in line with a thin
    // partition's end, triangles are slivers. So the bottom vertex is below the middle of a bin,
    // and deeper below thin partitions.
    const auto middle = [&](std::uint32_t bins_along) {
      return bins_along % 2 == 0 ? 0.5 * bins.pitch_m_ : 0.0;
    };
    const double deeper_m = world.partition_m < 0.01 * world.bin_m ? 4 * world.bin_m : 0;
    const std::uint32_t bottom =
        add({middle(bins.columns_), middle(bins.rows_), -(k_below_m + deeper_m)});
    for (const auto& [edge, unused] : edges) {
      const auto [a, b] = edge;
      if (edges.contains({b, a})) continue;
      const std::uint32_t below_a = lowered(a);
      const std::uint32_t below_b = lowered(b);
      quad(b, a, below_a, below_b);
      triangle(below_b, below_a, bottom);
    }
  }
};

Bins::Bins(const WorldParameters& world, std::uint32_t columns, std::uint32_t rows)
    : pitch_m_(world.bin_m + world.partition_m), columns_(columns), rows_(rows) {
  CHECK(columns > 0 && rows > 0);
  half_m_ = {0.5 * (columns * pitch_m_ - world.partition_m),
             0.5 * (rows * pitch_m_ - world.partition_m)};
  Builder builder{.world = world, .bins = *this};
  builder.add_partition_vertices();
  vertex_count_ = static_cast<std::uint32_t>(builder.vertices_m.size());
  builder.add_tops();
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i)
      builder.add_bin(i, j);
  }
  builder.close_below();
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      corners_.push_back({builder.corner(i, j, 1, 1), builder.corner(i + 1, j, 0, 1),
                          builder.corner(i + 1, j + 1, 0, 0), builder.corner(i, j + 1, 1, 0)});
    }
  }
  auto mesh = physics::TriangleMesh::make(builder.vertices_m, builder.triangles,
                                          physics::MeshClosure::closed);
  CHECK(mesh.ok());
  mesh_ = std::make_shared<const physics::TriangleMesh>(std::move(mesh).value());

  const double x = half_m_.x();
  const double y = half_m_.y();
  const double top = world.box_height_m;
  const double bottom = -2 * k_below_m;
  walls_.push_back(
      block("west wall", {-x - k_wall_m, -y - k_wall_m, bottom}, {-x, y + k_wall_m, top}));
  walls_.push_back(
      block("east wall", {x, -y - k_wall_m, bottom}, {x + k_wall_m, y + k_wall_m, top}));
  walls_.push_back(
      block("south wall", {-x - k_wall_m, -y - k_wall_m, bottom}, {x + k_wall_m, -y, top}));
  walls_.push_back(
      block("north wall", {-x - k_wall_m, y, bottom}, {x + k_wall_m, y + k_wall_m, top}));
}

physics::StaticPlane Bins::ground() const {
  return {.name = "ground", .outside = {.normal = {0, 0, 1}, .offset_m = -2 * k_below_m}};
}

std::optional<Bin> Bins::bin_at(const Vec3& place_m) const {
  if (std::fabs(place_m.x()) > half_m_.x() || std::fabs(place_m.y()) > half_m_.y())
    return std::nullopt;
  const auto index = [&](double place, std::uint32_t count) {
    const double at = std::floor(place / pitch_m_ + 0.5 * count);
    return static_cast<std::uint32_t>(std::clamp(at, 0.0, count - 1.0));
  };
  return Bin{.column = index(place_m.x(), columns_), .row = index(place_m.y(), rows_)};
}

Vec3 Bins::floor_middle_m(const Bin& bin) const {
  return {(bin.column + 0.5 - 0.5 * columns_) * pitch_m_, (bin.row + 0.5 - 0.5 * rows_) * pitch_m_,
          0};
}

std::shared_ptr<const physics::TriangleMesh> Bins::surface(std::span<const Vec3> offsets_m) const {
  CHECK_EQ(offsets_m.size(), std::size_t{vertex_count_});
  std::vector<physics::VertexMove> moves;
  moves.reserve(vertex_count_);
  for (std::uint32_t v = 0; v < vertex_count_; ++v)
    moves.push_back({.vertex = v, .position_m = mesh_->vertices_m()[v] + offsets_m[v]});
  auto moved = std::make_shared<physics::TriangleMesh>(*mesh_);
  if (moved->move_vertices(moves)) return nullptr;
  return moved;
}

}  // namespace sleight::worlds::spelling
