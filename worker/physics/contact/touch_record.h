// A body's record of an impact, for rest decisions.
//
// Thread safety: values.
#pragma once

#include <cstdint>

#include "worker/physics/event/ids.h"
#include "worker/physics/event/tick.h"
#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

/// The partner if a body touches static geometry.
inline constexpr BodyId k_static_partner{UINT32_MAX};

struct TouchRecord {
  Tick tick{};
  BodyId partner = k_static_partner;
  StaticId feature{};  ///< static feature, if the partner is static geometry
  double friction = 0;
  Vec3 normal = Vec3::Zero();  ///< from the partner to the body
  Vec3 arm_m = Vec3::Zero();   ///< from the body's centre to the contact
};

}  // namespace sleight::physics
