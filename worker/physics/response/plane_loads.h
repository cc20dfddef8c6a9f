// Computes the loads of a body that lies on an area of a plane, and the accelerations that the
// loads cause.
//
// Internal to worker/physics/response. Thread safety: pure functions.
#pragma once

#include <array>
#include <optional>

#include "worker/physics/response/plane_motion.h"

namespace sleight::physics {

/// A body that lies on an area. From the piece's start on, the frame turns with the body about the
/// normal.
class LyingBody {
 public:
  using Directions = std::array<Vec3, k_plane_supports_max>;

  LyingBody(const BodyOnPlane& body, double load_mps2);

  Vec3 slip_mps(std::size_t support, const Vec3& velocity_mps, double spin_radps) const {
    return velocity_mps + spin_radps * across_m_[support];
  }
  /// Returns n x arm.
  const Vec3& across_m(std::size_t support) const { return across_m_[support]; }
  /// Returns the greatest distance between a support and the centre of mass, measured along the
  /// plane.
  double radius_m() const { return radius_m_; }
  double spin_inertia_kgm2() const { return spin_inertia_kgm2_; }

  struct Rates {
    Vec3 acceleration_mps2 = Vec3::Zero();  ///< without the pull along the plane
    double spin_radps2 = 0;
    std::array<double, k_plane_supports_max> loads{};  ///< shares of the body's weight
  };
  /// Returns the loads and accelerations if friction acts against each support's slip. `slip`: one
  /// vector per support, in the slip's direction, of length 1 or less. Empty if the supports don't
  /// carry the body.
  std::optional<Rates> rates(const Directions& slip, double spin_radps) const;

 private:
  const BodyOnPlane& body_;
  double load_mps2_;  ///< gravity's part into the plane
  Vec3 first_;        ///< unit, along the plane
  Vec3 second_;
  double radius_m_ = 0;
  double spin_inertia_kgm2_ = 0;
  double first_coupling_ = 0;  ///< first.I n over n.I n
  double second_coupling_ = 0;
  double first_gyration_ = 0;  ///< first.(n x I n) over mass, gravity and radius
  double second_gyration_ = 0;
  std::array<Vec3, k_plane_supports_max> across_m_;
};

}  // namespace sleight::physics
