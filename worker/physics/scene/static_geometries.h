// Built static geometry that simulations of similar scenes share.
//
// Invariants
//   1. A scene gets the geometry that StaticGeometry(scene) would build.
//   2. Meshes and polyhedra are equal only if they are one object. A mesh that this object has seen
//      must not change as long as this object exists.
// Thread safety: all functions may be called from several threads. While one thread builds
// geometry, the others wait.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "worker/physics/scene/scene.h"
#include "worker/physics/scene/static_geometry.h"

namespace sleight::physics {

/// Whether StaticGeometry is the same for both scenes: whether all that it depends on is the same.
bool same_geometry(const Scene& a, const Scene& b);

class StaticGeometries {
 public:
  /// Keeps this many geometries, and forgets the one that was not used for longest. Scenes of one
  /// request differ at most in the size of their largest sphere (MovingKinds).
  static constexpr std::size_t k_geometries_max = 4;

  /// Builds the scene's geometry unless it is kept. REQUIRES: error_of(scene) has none.
  std::shared_ptr<const StaticGeometry> of(const Scene& scene) const;
  bool has(const Scene& scene) const;

 private:
  struct Kept {
    MovingKinds moving;
    Scene statics;  ///< without bodies
    std::shared_ptr<const StaticGeometry> geometry;
  };
  /// Moves the scene's geometry to the front. Returns null if it isn't kept.
  std::shared_ptr<const StaticGeometry> find(const Scene& scene) const;

  mutable std::mutex mutex_;
  mutable std::vector<Kept> kept_;  ///< last used first
};

/// Returns the scene's geometry, which Scene::geometries keeps if it is set.
std::shared_ptr<const StaticGeometry> geometry_of(const Scene& scene);

}  // namespace sleight::physics
