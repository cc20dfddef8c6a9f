// Which bin a ball can't leave any more by itself.
//
// A ball's energy, of its spin too, bounds the height that its centre reaches; no contact adds to
// it. Below the lowest corner of a bin's partitions the centre is between these, wherever it goes
// and whatever it hits, so it is there for good, unless another ball comes. Two balls that are so
// trapped in different bins never touch each other: between them stands a partition that neither
// reaches over.
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
  /// Borrows all; offsets are those of the partition vertices.
  Traps(const WorldParameters& world, const Bins& bins, std::span<const Vec3> offsets_m)
      : world_(world), bins_(bins), offsets_m_(offsets_m) {}

  struct Place {
    Bin bin;
    physics::Box box;  ///< the ball stays in it: the bin, as high as its energy takes it
  };
  /// Where a ball with its centre at a place is trapped; nothing if it may yet go elsewhere.
  std::optional<Place> of(const Vec3& centre_m, const physics::Twist& twist) const;

  struct Ball {
    Vec3 centre_m = Vec3::Zero();
    physics::Twist twist{};
    bool rests = false;
  };
  /// Whether each ball is where it will be for good: at rest, or trapped in a bin of its own that
  /// no ball at rest reaches over. A function of the balls' places alone: it doesn't depend on the
  /// engine or on how far that has simulated, as long as a trapped ball is given in a state that it
  /// has had since it was trapped.
  bool all_stay(std::span<const Ball> balls) const;

 private:
  const WorldParameters& world_;
  const Bins& bins_;
  std::span<const Vec3> offsets_m_;
};

}  // namespace sleight::worlds::spelling
