#include "worker/physics/response/plane_loads.h"

#include <algorithm>
#include <cmath>

#include "common/math/vector.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/linear_system.h"
#include "worker/physics/response/tangent.h"

namespace sleight::physics {
using math::cross;
using math::dot;
using math::norm;

LyingBody::LyingBody(const BodyOnPlane& body, double load_mps2)
    : body_(body),
      load_mps2_(load_mps2),
      first_(any_tangent(body.normal)),
      second_(cross(body.normal, first_)) {
  const Vec3& n = body.normal;
  for (std::size_t i = 0; i < body.supports.size(); ++i) {
    across_m_[i] = cross(n, body.supports[i].arm_m);
    radius_m_ = std::max(radius_m_, norm(across_m_[i]));
  }
  const Vec3 about_n = math::product(body.inertia_kgm2, n);
  spin_inertia_kgm2_ = dot(n, about_n);
  first_coupling_ = dot(first_, about_n) / spin_inertia_kgm2_;
  second_coupling_ = dot(second_, about_n) / spin_inertia_kgm2_;
  const Vec3 gyration = cross(n, about_n) / (body.mass_kg * load_mps2 * radius_m_);
  first_gyration_ = dot(first_, gyration);
  second_gyration_ = dot(second_, gyration);
}

std::optional<LyingBody::Rates> LyingBody::rates(const Directions& slip, double spin_radps) const {
  const Vec3& n = body_.normal;
  const std::size_t count = body_.supports.size();
  if (!(radius_m_ > 0)) return std::nullopt;
  // At each support, compute the push that a unit load causes, and its torques along the plane.
  // Subtract the torques that change the spin.
  std::array<Vec3, k_plane_supports_max> pushes;
  struct Row {
    double first_m, second_m;  ///< the support's place over the radius
    double first, second;      ///< torques over the radius
  };
  std::array<Row, k_plane_supports_max> rows;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& arm_m = body_.supports[i].arm_m;
    pushes[i] = n - body_.supports[i].friction * slip[i];
    const Vec3 torque = cross(arm_m, pushes[i]) / radius_m_;
    const double turning = dot(n, torque);
    rows[i] = {dot(first_, arm_m) / radius_m_, dot(second_, arm_m) / radius_m_,
               dot(first_, torque) - first_coupling_ * turning,
               dot(second_, torque) - second_coupling_ * turning};
  }
  std::array<std::size_t, k_plane_supports_max> pressed;
  std::size_t left = count;
  for (std::size_t i = 0; i < count; ++i)
    pressed[i] = i;
  Rates result;
  const double spin2 = spin_radps * spin_radps;
  while (left >= 3) {
    LinearSystem loads_of(3);
    for (std::size_t k = 0; k < left; ++k) {
      const Row& row = rows[pressed[k]];
      const std::array<double, 3> basis{1, row.first_m, row.second_m};
      for (std::size_t column = 0; column < 3; ++column) {
        loads_of.coefficient(0, column) += basis[column];
        loads_of.coefficient(1, column) += row.first * basis[column];
        loads_of.coefficient(2, column) += row.second * basis[column];
      }
    }
    loads_of.right(0) = 1;
    loads_of.right(1) = spin2 * first_gyration_;
    loads_of.right(2) = spin2 * second_gyration_;
    std::array<double, LinearSystem::k_most> linear{};
    if (!loads_of.solve(linear)) return std::nullopt;
    double least = 0;
    std::size_t worst = left;
    result.loads.fill(0);
    for (std::size_t k = 0; k < left; ++k) {
      const Row& row = rows[pressed[k]];
      const double load = linear[0] + linear[1] * row.first_m + linear[2] * row.second_m;
      result.loads[pressed[k]] = load;
      if (load < least) {
        least = load;
        worst = k;
      }
    }
    if (!(least < -k_load_rounding)) {
      // This test refuses NaN too.
      if (!(least >= -k_load_rounding)) return std::nullopt;
      Vec3 push = Vec3::Zero();
      double turning = 0;
      for (std::size_t k = 0; k < left; ++k) {
        double& load = result.loads[pressed[k]];
        load = std::max(load, 0.0);
        push += load * pushes[pressed[k]];
        turning += load * dot(n, cross(body_.supports[pressed[k]].arm_m, pushes[pressed[k]]));
      }
      push -= dot(n, push) * n;
      result.acceleration_mps2 = load_mps2_ * push;
      result.spin_radps2 = body_.mass_kg * load_mps2_ * turning / spin_inertia_kgm2_;
      return result;
    }
    std::copy(pressed.begin() + static_cast<std::ptrdiff_t>(worst) + 1,
              pressed.begin() + static_cast<std::ptrdiff_t>(left),
              pressed.begin() + static_cast<std::ptrdiff_t>(worst));
    --left;
  }
  return std::nullopt;
}

}  // namespace sleight::physics
