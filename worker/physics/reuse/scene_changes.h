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

/// Where static geometry differs. If a body with a margin of k_touch_m overlaps none of these
/// places, it meets the same static geometry in both scenes, with the same indices.
struct ChangedPlaces {
  BoxTree boxes;  ///< of changed pieces and features, before and after
  bool has_boxes = false;
  std::vector<HalfSpace> outside;  ///< changed planes, before and after

  bool none() const { return !has_boxes && outside.empty(); }
  bool meet(const Box& body) const;
};

struct SceneChanges {
  /// Whether everything may differ. This is so if the number of bodies, the laws or the meaning of
  /// indices changed. It is also so if some bodies start at rest, and these bodies or static
  /// geometry changed.
  bool laws = false;
  std::vector<std::uint8_t> bodies{};  ///< by body: whether the body or its start has changed
  ChangedPlaces places{};
  std::size_t same_controls =
      0;  ///< number of equal controls before the first difference, in event order
  /// In neither scene does a changed body or control have an effect before this tick.
  Tick first = k_never;
};

/// Compares two scenes. Functions can't be compared. REQUIRES: a body with the same start has the
/// same `start_again`; `statics` is the geometry of `after`.
SceneChanges changes_between(const Scene& before, const Scene& after,
                             const StaticGeometry& statics);

/// Returns the indices of a scene's controls in event order.
std::vector<std::uint32_t> controls_in_order(const Scene& scene);

}  // namespace sleight::physics
