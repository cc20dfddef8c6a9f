// The numbers of a body's segment that every world's archive has, in the order of its columns.
#pragma once

#include <vector>

#include "common/math/rotation.h"
#include "worker/physics/simulator/segment.h"

namespace sleight::worlds {

inline void append_vector(const math::Vec3& v, std::vector<double>& values) {
  values.insert(values.end(), {v.x(), v.y(), v.z()});
}

/// As w, x, y, z.
inline void append_quaternion(const math::Quat& q, std::vector<double>& values) {
  values.insert(values.end(), {q.w(), q.x(), q.y(), q.z()});
}

/// Appends 18 numbers: the segment's start (s), its mode, the centre's position (m), velocity (m/s)
/// and acceleration (m/s^2), this orientation at the start, the angular velocity (rad/s).
void append_segment(const physics::Segment& segment, const math::Quat& orientation,
                    std::vector<double>& values);

}  // namespace sleight::worlds
