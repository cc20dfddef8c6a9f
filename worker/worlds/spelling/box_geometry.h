// The simulator's geometry of the box of bins, reused between simulations. Only moved partition
// vertices are updated, since most proposals move few vertices or none.
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
  /// `with_bodies`: a scene of a box without offsets, with at least one body.
  BoxGeometry(const physics::Scene& with_bodies, std::shared_ptr<physics::TriangleMesh> mesh,
              std::uint32_t vertices);

  /// Moves the partition vertices to these offsets. Returns false, without any change, if the
  /// offsets turn the box inside out.
  [[nodiscard]] bool move_to(const Bins& bins, std::span<const Vec3> offsets_m);

  /// Counts the vertices that would have to move, among a fixed selection of vertices.
  std::size_t moves_to(std::span<const Vec3> offsets_m) const;
  /// The mesh stays unchanged until the next move.
  const std::shared_ptr<physics::TriangleMesh>& mesh() const { return mesh_; }
  const physics::NearFeatures& near() const { return near_; }
  /// The simulator, which reuses its memory from one simulation to the next.
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

  /// Returns the free geometry that is nearest to these offsets, or a new one from `make`. So each
  /// thread mostly gets the geometry of its last simulation again.
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
