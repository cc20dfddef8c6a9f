#include "tests/unit/worker/physics/response/stepped_ball.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "common/math/vector.h"

namespace sleight::physics::response_reference {
namespace {

using math::cross;
using math::dot;
using math::norm;

/// Sweeps end when no impulse changes by more than this fraction of gravity's impulse.
constexpr double k_settled = 1e-10;
constexpr int k_sweeps_max = 2000;

Vec3 within(const Vec3& impulse, double most) {
  const double size = norm(impulse);
  return size <= most ? impulse : Vec3((most / size) * impulse);
}

}  // namespace

SteppedBall::SteppedBall(const RoundBody& body, std::span<const LastingContact> planes,
                         const Twist& twist, const Vec3& gravity_mps2, double step_s)
    : body_(body), count_(planes.size()), twist_(twist), gravity_(gravity_mps2), step_s_(step_s) {
  Mat3 products = Mat3::Identity();
  for (std::size_t i = 0; i < count_; ++i) {
    contacts_[i].plane = planes[i];
    for (std::size_t j = 0; j < count_; ++j)
      products(static_cast<int>(i), static_cast<int>(j)) = dot(planes[i].normal, planes[j].normal);
  }
  loads_of_rates_ = products.inverse();
}

double SteppedBall::sweep_loads() {
  // Solve for all loads at once, because the ball stays on all planes.
  Vec3 rates = Vec3::Zero();
  for (std::size_t i = 0; i < count_; ++i)
    rates[static_cast<int>(i)] = dot(twist_.velocity_mps, contacts_[i].plane.normal);
  const Vec3 changes = -(loads_of_rates_ * rates);
  for (std::size_t i = 0; i < count_; ++i) {
    const double change = changes[static_cast<int>(i)];
    contacts_[i].load += change;
    twist_.velocity_mps += change * contacts_[i].plane.normal;
  }
  return changes.cwiseAbs().maxCoeff();
}

double SteppedBall::sweep_friction() {
  double most = 0;
  for (Contact& contact : contacts()) {
    const Vec3& n = contact.plane.normal;
    Vec3 slip = twist_.velocity_mps + cross(twist_.angular_velocity_radps, -body_.radius_m * n);
    slip -= dot(slip, n) * n;
    // A unit impulse at the surface changes the surface's velocity by 1 + 1/k: 1 by translation,
    // and 1/k by rotation.
    const Vec3 wanted = contact.friction - slip / (1 + 1 / body_.gyration);
    const Vec3 change =
        within(wanted, contact.plane.friction * std::max(0.0, contact.load)) - contact.friction;
    contact.friction += change;
    twist_.velocity_mps += change;
    twist_.angular_velocity_radps +=
        cross(-body_.radius_m * n, change) / (body_.gyration * body_.radius_m * body_.radius_m);
    most = std::max(most, norm(change));
  }
  return most;
}

double SteppedBall::sweep_resistance() {
  double most = 0;
  const double r = body_.radius_m;
  const double inertia = body_.gyration * r * r;
  Vec3& w = twist_.angular_velocity_radps;
  for (Contact& contact : contacts()) {
    const double moment_max = contact.plane.rolling_friction * r * std::max(0.0, contact.load);
    if (moment_max == 0) continue;
    const Vec3& n = contact.plane.normal;
    if (count_ == 1) {
      const double wanted = contact.pivot_moment - inertia * dot(w, n);
      const double change = std::clamp(wanted, -moment_max, moment_max) - contact.pivot_moment;
      contact.pivot_moment += change;
      w += (change / inertia) * n;
      most = std::max(most, std::fabs(change) / r);
    }
    if (!rolls_ || count_ == 3) continue;
    const Vec3 braked = count_ == 1 ? Vec3(w - dot(w, n) * n) : w;
    const Vec3 wanted = contact.moment - inertia * braked;
    const Vec3 change = within(wanted, (1 + body_.gyration) * moment_max) - contact.moment;
    contact.moment += change;
    w += change / inertia;
    most = std::max(most, norm(change) / r);
  }
  return most;
}

void SteppedBall::step() {
  const Vec3 before_mps = twist_.velocity_mps;
  twist_.velocity_mps += step_s_ * gravity_;
  for (Contact& contact : contacts())
    contact = {.plane = contact.plane};
  const double settled = k_settled * step_s_ * norm(gravity_);
  int sweeps = 0;
  for (; sweeps < k_sweeps_max; ++sweeps) {
    const double loads = sweep_loads();
    const double friction = sweep_friction();
    const double resistance = sweep_resistance();
    if (std::max({loads, friction, resistance}) <= settled) break;
  }
  CHECK(sweeps < k_sweeps_max);
  sweep_loads();
  rolls_ = true;
  for (const Contact& contact : contacts()) {
    if (contact.load < 0) pulled_ = true;
    if (norm(contact.friction) >= contact.plane.friction * contact.load * (1 - 1e-9))
      rolls_ = false;
  }
  way_m_ += (0.5 * step_s_) * (before_mps + twist_.velocity_mps);
}

}  // namespace sleight::physics::response_reference
