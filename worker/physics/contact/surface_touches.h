// Where bodies touched spline surfaces.
//
// Thread safety: values.
#pragma once

#include <cstdint>

#include "common/math/vector.h"
#include "worker/physics/event/ids.h"
#include "worker/physics/event/tick.h"

namespace sleight::physics {

struct SurfaceTouch {
  Tick tick{};
  BodyId body{};
  std::uint32_t surface = 0;  ///< index in the scene
  math::Vec3 point_m = math::Vec3::Zero();
};

}  // namespace sleight::physics
