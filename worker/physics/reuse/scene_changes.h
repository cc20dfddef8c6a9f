// The differences between two scenes that may change a simulation.
//
// Thread safety: values and pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/event/tick.h"
#include "worker/physics/scene/box_tree.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/scene/static_geometry.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {

/// Where static geometry differs. If a body, widened by k_touch_m, overlaps none of these places,
/// it meets the same static geometry, with the same indices, in both scenes.
struct ChangedPlaces {
  BoxTree boxes;  ///< of changed pieces and features, before and after
  bool has_boxes = false;
  std::vector<HalfSpace> outside;  ///< changed planes, before and after

  bool none() const { return !has_boxes && outside.empty(); }
  bool meet(const Box& body) const;
};

struct SceneChanges {
  /// Whether everything may differ: if the number of bodies, the laws or the meaning of indices
  /// changed.
  bool laws = false;
  std::vector<std::uint8_t> bodies{};  ///< by body: whether the body or its start has changed
  ChangedPlaces places{};
  std::size_t same_controls =
      0;  ///< number of equal controls before the first difference, in event order
  /// Before this tick, changed bodies and controls have no effect in either scene.
  Tick first = k_never;
};

/// Compares two scenes. Functions can't be compared. REQUIRES: bodies with equal starts have equal
/// `start_again`; `statics` is the geometry of `after`.
SceneChanges changes_between(const Scene& before, const Scene& after,
                             const StaticGeometry& statics);

/// Returns the indices of a scene's controls in event order.
std::vector<std::uint32_t> controls_in_order(const Scene& scene);

}  // namespace sleight::physics
