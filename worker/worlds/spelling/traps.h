// Traps: bins that a ball can't leave by itself.
//
// A ball's energy, including its spin, bounds the height that its centre can reach, and no contact
// adds energy. Below the lowest corner of a bin's partitions, the centre stays between the
// partitions whatever the ball hits. So the ball can leave the bin only if another ball comes. Two
// balls trapped in different bins never touch each other, because neither can reach over the
// partition between them.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <optional>
#include <span>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/worlds/spelling/bins.h"
#include "worker/worlds/spelling/parameters.h"

namespace sleight::worlds::spelling {

class Traps {
 public:
  /// Borrows all arguments. `offsets_m`: of the partition vertices.
  Traps(const WorldParameters& world, const Bins& bins, std::span<const Vec3> offsets_m)
      : world_(world), bins_(bins), offsets_m_(offsets_m) {}

  struct Place {
    Bin bin;
    physics::Box box;  ///< the ball stays in it: the bin, as high as energy allows
  };
  /// Returns where a ball is trapped, or nothing if it may still leave.
  std::optional<Place> of(const Vec3& centre_m, const physics::Twist& twist) const;

  struct Ball {
    Vec3 centre_m = Vec3::Zero();
    physics::Twist twist{};
    bool rests = false;
  };
  /// Whether each ball is in its final place. A ball's final place is at rest, or trapped in a bin
  /// where the ball can touch no other ball. The result depends only on the balls' places, not on
  /// the engine or on how far the engine has simulated. For a trapped ball, pass any state that it
  /// had since it was trapped.
  bool all_stay(std::span<const Ball> balls) const;

 private:
  const WorldParameters& world_;
  const Bins& bins_;
  std::span<const Vec3> offsets_m_;
};

}  // namespace sleight::worlds::spelling
