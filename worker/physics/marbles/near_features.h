// What static geometry a ball of one size may touch next, as a table.
//
// Idea. Each feature has a touch box: it holds every centre from which a ball touches the feature
// in its region. Space is cut into cells, each with the list of the features whose touch boxes come
// near it. A path that stays near a cell can touch only what is in the cell's list, and of that,
// what has a touch box that the path's box overlaps: four numbers at a time.
//
// Vertices that move change touch boxes, which are made anew, and not lists: these are made for
// homes, which hold touch boxes and some slack. A home only grows, when a touch box outgrows it; so
// after a few moves of all vertices hardly any list changes.
//
// Invariants
//   1. A ball whose centre is outside of a feature's touch box does not collide with it, rounding
//      included.
//   2. A list ascends, and holds every feature whose home overlaps the cell's reach.
// Thread safety: const functions may run at once.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/marbles/four.h"
#include "worker/physics/marbles/touch_box.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/scene/static_geometry.h"

namespace sleight::physics {

class NearFeatures {
 public:
  /// Of balls of a radius. Borrows the geometry.
  NearFeatures(const StaticGeometry& statics, double radius_m);
  /// The geometry has been refreshed.
  void refresh();

  double radius_m() const { return radius_m_; }
  const StaticGeometry& statics() const { return statics_; }

  struct Cell {
    Four low_m;   ///< of its reach: the cell, and some margin on each side
    Four high_m;  ///< as good as infinite where no cell is beyond
    std::span<const FeatureId> faces;
    std::span<const FeatureId> corners;  ///< edges and vertices
  };
  /// Inline, since it is asked for each part of each path. REQUIRES: the fourth number is 0.
  Cell cell_at(const Four& centre_m) const;
  /// Faces that belong to all cells: planes.
  std::span<const FeatureId> everywhere() const { return everywhere_; }
  /// By feature.
  std::span<const TouchBox> touch_boxes() const { return touch_boxes_; }
  /// No less than the sum of |coordinates| of any feature's point.
  double coordinates_m() const { return coordinates_m_; }

 private:
  TouchBox touch_box_of_plane(FeatureId plane) const;
  void measure_features();
  float reach_m() const { return static_cast<float>(radius_m_ + 2 * k_touch_m); }
  void enlarge_home(FeatureId feature);
  void grow_home(FeatureId feature);
  /// Cells from the first up to, and without, the last of each axis.
  struct Range {
    std::array<std::uint32_t, 3> from{};
    std::array<std::uint32_t, 3> to{};
    bool holds(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
      return x >= from[0] && x < to[0] && y >= from[1] && y < to[1] && z >= from[2] && z < to[2];
    }
  };
  Range cells_of(const TouchBox& box) const;
  template <class Visit>
  void for_each_cell(const Range& range, const Range& without, const Visit& visit) const;
  std::size_t list_of(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (std::size_t{z} * counts_[1] + y) * counts_[0] + x;
  }

  const StaticGeometry& statics_;
  double radius_m_;
  std::vector<TouchBox> touch_boxes_;
  std::vector<FeatureExtent> extents_;
  std::uint64_t boxes_made_ = 0;     ///< the geometry's count when extents were
  std::vector<TouchBox> homes_;      ///< for which lists were made
  std::vector<FeatureId> outgrown_;  ///< while refreshing
  std::vector<FeatureId> everywhere_;
  // Cells, x fastest.
  std::array<double, 4> origin_m_{};
  std::array<std::uint32_t, 3> counts_{1, 1, 1};
  std::array<double, 4> last_cell_{};  ///< of each axis: its number
  std::array<double, 4> strides_{};    ///< from a list to that of the next cell along each axis
  double coordinates_m_ = 0;
  double cell_m_ = 1;
  double cells_per_m_ = 1;
  double margin_m_ = 0;
  struct List {
    std::vector<FeatureId> faces;
    std::vector<FeatureId> corners;
  };
  std::vector<List> lists_;
};

inline NearFeatures::Cell NearFeatures::cell_at(const Four& centre_m) const {
  // Farther than any path, and its square is a number still.
  const Four far = Four::all(1e30);
  const Four half = Four::all(0.5);
  const Four origin_m = Four::of(origin_m_);
  const Four last = Four::of(last_cell_);
  const Four place = (centre_m - origin_m) * Four::all(cells_per_m_);
  const Four number = whole_part(max(min(place, last), Four::zero()));
  const Four low_m = origin_m + (number * Four::all(cell_m_) - Four::all(margin_m_));
  const Four high_m = low_m + Four::all(cell_m_ + 2 * margin_m_);
  // Numbers are whole, and so is their sum: exact.
  const List& lists = lists_[static_cast<std::size_t>(dot(number, Four::of(strides_)))];
  return {.low_m = choose_if_less(number, half, Four::zero() - far, low_m),
          .high_m = choose_if_less(last - half, number, far, high_m),
          .faces = lists.faces,
          .corners = lists.corners};
}

}  // namespace sleight::physics
