// A sphere's motion in a valley of two faces, computed with a linear system.
//
// Thread safety: pure functions.
#pragma once

#include <span>

#include "worker/physics/response/contact_motion.h"

namespace sleight::physics {

/// REQUIRES: two contacts that form a valley (is_valley).
ContactMotion valley_motion(const RoundBody& body, std::span<const LastingContact> contacts,
                            const Twist& twist, const Vec3& gravity_mps2);

}  // namespace sleight::physics
