// The box of bins as a simulator meets it, kept between simulations: only what has moved is made
// anew, since most proposals move few partition vertices or none.
//
// Thread safety: BoxGeometry none; BoxGeometries may be used by several threads at once.
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
  /// `with_bodies`: the scene of a box without offsets, and with a body.
  BoxGeometry(const physics::Scene& with_bodies, std::shared_ptr<physics::TriangleMesh> mesh,
              std::uint32_t vertices);

  /// Moves the partition vertices there. False if that turns the box inside out; then nothing has
  /// changed.
  [[nodiscard]] bool move_to(const Bins& bins, std::span<const Vec3> offsets_m);

  /// Of some vertices, the same ones each time, how many would have to move there.
  std::size_t moves_to(std::span<const Vec3> offsets_m) const;
  /// As it is until the next move.
  const std::shared_ptr<physics::TriangleMesh>& mesh() const { return mesh_; }
  const physics::NearFeatures& near() const { return near_; }
  /// Its memory serves one simulation after the other.
  physics::Marbles& marbles() { return marbles_; }

 private:
  std::shared_ptr<physics::TriangleMesh> mesh_;
  std::unique_ptr<physics::StaticGeometry> statics_;
  physics::NearFeatures near_;
  physics::Marbles marbles_;
  std::vector<Vec3> offsets_m_;  ///< present ones
  std::vector<physics::VertexMove> moves_;
};

/// Lends each simulation that runs one of its own.
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

  /// The free one that is nearest to these offsets, or what `make` makes: each of several threads
  /// so mostly gets its own back, which is where its last simulation was.
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
