// A body's pose as a matrix, and the pose of one body in another body's frame.
//
// A distance computation transforms dozens of vectors between two frames. A matrix needs 9
// multiplications per vector, a quaternion 15 to 18. So each body's quaternion is converted to a
// matrix once. Thread safety: values and pure functions.
#pragma once

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

/// world = product(rotation, body) + position_m.
struct PlacedPose {
  Mat3 rotation = Mat3::Identity();
  Vec3 position_m = Vec3::Zero();
};

inline PlacedPose placed(const Pose& pose) {
  return {.rotation = math::matrix_of(pose.orientation), .position_m = pose.position_m};
}

inline Vec3 to_world(const PlacedPose& pose, const Vec3& body_m) {
  return math::product(pose.rotation, body_m) + pose.position_m;
}

/// Returns product(m^T, v). If m is a body's rotation, this converts v to the body's axes.
inline Vec3 transposed_product(const Mat3& m, const Vec3& v) {
  return {(m(0, 0) * v.x() + m(1, 0) * v.y()) + m(2, 0) * v.z(),
          (m(0, 1) * v.x() + m(1, 1) * v.y()) + m(2, 1) * v.z(),
          (m(0, 2) * v.x() + m(1, 2) * v.y()) + m(2, 2) * v.z()};
}

/// Returns B's pose in A's frame. The error is about 2^-52 of the distance of the positions.
inline PlacedPose relative_pose(const PlacedPose& a, const PlacedPose& b) {
  PlacedPose result;
  for (int j = 0; j < 3; ++j) {
    const Vec3 column = b.rotation.col(j);
    result.rotation.col(j) = transposed_product(a.rotation, column);
  }
  result.position_m = transposed_product(a.rotation, b.position_m - a.position_m);
  return result;
}

/// If `pose` is B's pose in A's frame, returns A's pose in B's frame.
inline PlacedPose inverse(const PlacedPose& pose) {
  return {.rotation = pose.rotation.transpose(),
          .position_m = -transposed_product(pose.rotation, pose.position_m)};
}

}  // namespace sleight::physics
