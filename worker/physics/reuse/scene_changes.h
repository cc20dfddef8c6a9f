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

/// Where static geometry differs: a body that overlaps none of these places, with all of itself and
/// k_touch_m around it, meets the same in both scenes, under the same indices.
struct ChangedPlaces {
  BoxTree boxes;  ///< of pieces and features, as they were and as they are
  bool has_boxes = false;
  std::vector<HalfSpace> outside;  ///< the same of planes

  bool none() const { return !has_boxes && outside.empty(); }
  bool meet(const Box& body) const;
};

struct SceneChanges {
  /// Nothing is the same: another number of bodies, other laws, lists that mean something else, or
  /// bodies that start at rest and others of these, or other static geometry.
  bool laws = false;
  std::vector<std::uint8_t> bodies{};  ///< by body: whether itself or its start is another one
  ChangedPlaces places{};
  std::size_t same_controls = 0;  ///< in the order of their events, up to the first that differs
  /// Bodies and controls that differ do nothing before this tick in either scene.
  Tick first = k_never;
};

/// Functions can't be compared. REQUIRES: a body with the same start has the same start_again.
/// `statics` are those of `after`.
SceneChanges changes_between(const Scene& before, const Scene& after,
                             const StaticGeometry& statics);

/// A scene's controls as indices, in the order of their events.
std::vector<std::uint32_t> controls_in_order(const Scene& scene);

}  // namespace sleight::physics
