// The simulator's geometry of the box of bins. Simulations reuse the geometry. A simulation updates
// only moved partition vertices, because most proposals move few vertices or none.
// Thread safety: BoxGeometry isn't thread-safe; BoxGeometries is.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "worker/physics/marbles/marbles.h"
#include "worker/physics/marbles/near_features.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/scene/static_geometry.h"
#include "worker/physics/shape/triangle_mesh.h"
#include "worker/worlds/spelling/bins.h"

namespace sleight::worlds::spelling {

class BoxGeometry {
 public:
  /// `with_bodies` is a scene of a box. The box has no offsets. REQUIRES: the scene has a body.
  BoxGeometry(const physics::Scene& with_bodies, std::shared_ptr<physics::TriangleMesh> mesh,
              std::uint32_t vertices);

  /// Moves the partition vertices to these offsets. If the offsets turn the box inside out, changes
  /// nothing and returns false.
  [[nodiscard]] bool move_to(const Bins& bins, std::span<const Vec3> offsets_m);

  /// Returns how many vertices of a fixed selection would have to move.
  std::size_t moves_to(std::span<const Vec3> offsets_m) const;
  /// The mesh stays unchanged until the next move.
  const std::shared_ptr<physics::TriangleMesh>& mesh() const { return mesh_; }
  const physics::NearFeatures& near() const { return near_; }
  /// The simulator reuses its memory from one simulation to the next.
  physics::Marbles& marbles() { return marbles_; }

 private:
  std::shared_ptr<physics::TriangleMesh> mesh_;
  std::unique_ptr<physics::StaticGeometry> statics_;
  physics::NearFeatures near_;
  physics::Marbles marbles_;
  std::vector<Vec3> offsets_m_;
  std::vector<physics::VertexMove> moves_;
};

/// Lends a BoxGeometry to each running simulation.
class BoxGeometries {
 public:
  class Loan {
   public:
    Loan(BoxGeometries& from, std::unique_ptr<BoxGeometry> geometry)
        : from_(from), geometry_(std::move(geometry)) {}
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    ~Loan();
    BoxGeometry& operator*() const { return *geometry_; }
    BoxGeometry* operator->() const { return geometry_.get(); }

   private:
    BoxGeometries& from_;
    std::unique_ptr<BoxGeometry> geometry_;
  };

  /// Returns the free geometry nearest to these offsets. If no geometry is free, returns what
  /// `make` makes. So each thread mostly gets the geometry of its last simulation again.
  template <class Make>
  Loan borrow(std::span<const Vec3> offsets_m, const Make& make) {
    if (auto free = take(offsets_m)) return Loan(*this, std::move(free));
    return Loan(*this, make());
  }

 private:
  std::unique_ptr<BoxGeometry> take(std::span<const Vec3> offsets_m);

  std::mutex mutex_;
  std::vector<std::unique_ptr<BoxGeometry>> free_;
};

}  // namespace sleight::worlds::spelling
