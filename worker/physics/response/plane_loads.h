// The loads of a body that lies on an area of a plane, and what they do to it.
//
// Internal to worker/physics/response. Thread safety: pure functions.
#pragma once

#include <array>
#include <optional>

#include "worker/physics/response/plane_motion.h"

namespace sleight::physics {

/// A body that lies on an area, seen from where its supports are at the piece's start: what turns
/// with it about the normal is turned back instead.
class LyingBody {
 public:
  using Directions = std::array<Vec3, k_plane_supports_max>;

  LyingBody(const BodyOnPlane& body, double load_mps2);

  /// How supports slip.
  Vec3 slip_mps(std::size_t support, const Vec3& velocity_mps, double spin_radps) const {
    return velocity_mps + spin_radps * across_m_[support];
  }
  /// n x arm.
  const Vec3& across_m(std::size_t support) const { return across_m_[support]; }
  /// Radius of what it lies on, about the centre's foot.
  double radius_m() const { return radius_m_; }
  double spin_inertia_kgm2() const { return spin_inertia_kgm2_; }

  struct Rates {
    Vec3 acceleration_mps2 = Vec3::Zero();  ///< without the pull along the plane
    double spin_radps2 = 0;
    std::array<double, k_plane_supports_max> loads{};  ///< parts of the body's weight
  };
  /// What friction does that acts at each support against such a direction, of length 1 or less;
  /// none if the supports don't carry the body.
  std::optional<Rates> rates(const Directions& slip, double spin_radps) const;

 private:
  const BodyOnPlane& body_;
  double load_mps2_;  ///< of gravity, on the plane
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
