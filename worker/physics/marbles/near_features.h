// Finds the static features that a ball of a given size may touch near a place.
//
// Idea. Each feature has a touch box. If a ball touches the feature from inside the feature's
// region, the ball's centre is in the touch box. Space is divided into cells. Each cell lists the
// features whose touch boxes come near the cell. A path near a cell can touch a feature only if the
// cell lists the feature and the feature's touch box overlaps the path's box. The overlap test
// compares four numbers at a time.
//
// When vertices move, touch boxes are recomputed, but lists rarely change. Lists depend on homes. A
// home is a touch box with some slack. A home never shrinks, and grows only when its touch box
// leaves it. So after a few moves of all vertices, hardly any list changes.
//
// Invariants
//   1. If a ball's centre is outside a feature's touch box, the ball doesn't collide with the
//      feature, even with rounding.
//   2. Lists are ascending, and contain every feature whose home overlaps the cell's reach.
// Thread safety: const functions may run concurrently.
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
  /// Borrows the geometry.
  NearFeatures(const StaticGeometry& statics, double radius_m);
  /// Updates the table after the geometry's refresh().
  void refresh();

  double radius_m() const { return radius_m_; }
  const StaticGeometry& statics() const { return statics_; }

  struct Cell {
    Four low_m;   ///< lower corner of its reach: the cell and a margin on each side
    Four high_m;  ///< upper corner; both are practically infinite at the outermost cells
    std::span<const FeatureId> faces;
    std::span<const FeatureId> corners;  ///< edges and vertices
  };
  /// Returns the cell that contains a centre. Inline for speed, since it is called for each part of
  /// each path. REQUIRES: the fourth number is 0.
  Cell cell_at(const Four& centre_m) const;
  /// Planes, which belong to all cells.
  std::span<const FeatureId> everywhere() const { return everywhere_; }
  std::span<const TouchBox> touch_boxes() const { return touch_boxes_; }
  /// Upper bound for the sum of |coordinates| of any feature's point.
  double coordinates_m() const { return coordinates_m_; }

 private:
  TouchBox touch_box_of_plane(FeatureId plane) const;
  void measure_features();
  float reach_m() const { return static_cast<float>(radius_m_ + 2 * k_touch_m); }
  void enlarge_home(FeatureId feature);
  void grow_home(FeatureId feature);
  /// Cell numbers on each axis, from `from` to `to` - 1.
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
  std::uint64_t boxes_made_ = 0;     ///< geometry's boxes_made() at the last measure_features()
  std::vector<TouchBox> homes_;      ///< lists are based on these
  std::vector<FeatureId> outgrown_;  ///< while refreshing
  std::vector<FeatureId> everywhere_;
  // Cells, x fastest.
  std::array<double, 4> origin_m_{};
  std::array<std::uint32_t, 3> counts_{1, 1, 1};
  std::array<double, 4> last_cell_{};  ///< by axis: number of the last cell
  std::array<double, 4> strides_{};    ///< by axis: index step between the lists of adjacent cells
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
  // This distance is farther than any path, and its square is finite.
  const Four far = Four::all(1e30);
  const Four half = Four::all(0.5);
  const Four origin_m = Four::of(origin_m_);
  const Four last = Four::of(last_cell_);
  const Four place = (centre_m - origin_m) * Four::all(cells_per_m_);
  const Four number = whole_part(max(min(place, last), Four::zero()));
  const Four low_m = origin_m + (number * Four::all(cell_m_) - Four::all(margin_m_));
  const Four high_m = low_m + Four::all(cell_m_ + 2 * margin_m_);
  // All terms are whole numbers, so their sum is exact.
  const List& lists = lists_[static_cast<std::size_t>(dot(number, Four::of(strides_)))];
  return {.low_m = choose_if_less(number, half, Four::zero() - far, low_m),
          .high_m = choose_if_less(last - half, number, far, high_m),
          .faces = lists.faces,
          .corners = lists.corners};
}

}  // namespace sleight::physics
