// What static geometry a ball of one size may touch next, as a table.
//
// Idea. Each feature has a touch box: it holds every centre from which a ball touches the feature
// in its region. Space is cut into cells, each with the list of the features whose touch boxes come
// near it. A path that stays near a cell can touch only what is in the cell's list, and of that,
// what has a touch box that the path's box overlaps: four numbers at a time.
//
// Vertices that move change touch boxes, which are made anew, and not lists: these are made for
// touch boxes that are larger by some slack. A feature whose touch box outgrows that is a stray and
// belongs to all cells.
//
// Invariants
//   1. A ball whose centre is outside of a feature's touch box does not collide with it, rounding
//      included.
//   2. A list ascends, and holds every feature whose touch box overlaps the cell's reach.
// Thread safety: const functions may run at once.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/simulator/static_geometry.h"

namespace sleight::physics {

/// A box in whole registers; the fourth numbers are 0.
struct alignas(32) TouchBox {
  std::array<float, 4> low_m{};
  std::array<float, 4> high_m{};
};

/// Whether two boxes overlap.
bool overlaps(const TouchBox& a, const TouchBox& b);

class NearFeatures {
 public:
  /// Of balls of a radius. Borrows the geometry.
  NearFeatures(const StaticGeometry& statics, double radius_m);
  /// The geometry has been refreshed.
  void refresh();

  double radius_m() const { return radius_m_; }
  const StaticGeometry& statics() const { return statics_; }

  struct Cell {
    std::array<double, 3> low_m;   ///< of its reach: the cell, and some margin on each side
    std::array<double, 3> high_m;  ///< infinite where no cell is beyond
    std::span<const std::uint32_t> features;
  };
  Cell cell_at(const Vec3& centre_m) const;
  /// Those that belong to all cells.
  std::span<const std::uint32_t> strays() const { return strays_; }
  const TouchBox& touch_box(std::uint32_t feature) const { return touch_boxes_[feature]; }

 private:
  TouchBox touch_box_of(std::uint32_t feature) const;
  void make_lists();
  template <class Visit>
  void for_each_cell(const TouchBox& box, const Visit& visit) const;

  const StaticGeometry& statics_;
  double radius_m_;
  std::vector<TouchBox> touch_boxes_;
  std::vector<TouchBox> homes_;  ///< of which lists were made
  std::vector<std::uint32_t> strays_;
  std::vector<std::uint8_t> is_stray_;
  // Cells, x fastest.
  std::array<double, 3> origin_m_{};
  std::array<std::uint32_t, 3> counts_{1, 1, 1};
  double cell_m_ = 1;
  double margin_m_ = 0;
  std::vector<std::uint32_t> first_;  ///< of each cell's list in members_
  std::vector<std::uint32_t> members_;
};

}  // namespace sleight::physics
