#include "worker/physics/contact/weight_balance.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "common/math/vector.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/tangent.h"

namespace sleight::physics {
namespace {

/// A push's force, and its torque divided by the reach.
struct Wrench {
  Vec3 force;
  Vec3 torque;
};

double product(const Wrench& a, const Wrench& b) {
  return math::dot(a.force, b.force) + math::dot(a.torque, b.torque);
}

/// The possible pushes of contacts. Each push has a share in the last balance. Similar weights have
/// similar shares, so the next search starts from the last shares.
class Balance {
 public:
  Balance(std::span<const TouchRecord> contacts, double reach_m) : reach_m_(reach_m) {
    for (const TouchRecord& touch :
         contacts.first(std::min(contacts.size(), k_touch_records_max))) {
      const Vec3 first = any_tangent(touch.normal);
      const Vec3 second = math::cross(touch.normal, first);
      for (const Vec3& tangent : {first, Vec3(-first), second, Vec3(-second)}) {
        const Vec3 force = touch.normal + touch.friction * tangent;
        const Wrench push{force, math::cross(touch.arm_m, force) / reach_m};
        inverse_squares_[count_] = 1 / product(push, push);
        pushes_[count_++] = push;
      }
    }
  }

  Contacts pushing() const {
    Contacts contacts = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (share_[i] > 0) contacts |= Contacts{1} << (i / k_edges);
    }
    return contacts;
  }

  /// Uses non-negative least squares by coordinate descent. `direction`: unit vector of the weight.
  bool carries(const Vec3& direction, const Vec3& weight_at_m) {
    constexpr double k_enough = k_balance_tolerance * k_balance_tolerance;
    Wrench rest{direction, math::cross(weight_at_m, direction) / reach_m_};
    for (std::size_t i = 0; i < count_; ++i) {
      rest.force += share_[i] * pushes_[i].force;
      rest.torque += share_[i] * pushes_[i].torque;
    }
    double earlier = product(rest, rest);
    for (int sweep = 0; sweep < k_balance_sweeps_max; ++sweep) {
      const double left = product(rest, rest);
      if (left < k_enough) return true;
      if (sweep % k_balance_sweeps_judged == 0 && sweep > 0) {
        if (is_hopeless(left, left / earlier, k_balance_sweeps_max - sweep)) return false;
        earlier = left;
      }
      for (std::size_t i = 0; i < count_; ++i) {
        const double better =
            std::max(0.0, share_[i] - product(rest, pushes_[i]) * inverse_squares_[i]);
        const double change = better - share_[i];
        if (change == 0) continue;
        share_[i] = better;
        rest.force += change * pushes_[i].force;
        rest.torque += change * pushes_[i].torque;
      }
    }
    return false;
  }

 private:
  /// Edges of a friction pyramid.
  static constexpr std::size_t k_edges = 4;

  /// Returns whether the imbalance would stay too large even if it fell twice as fast as now.
  static bool is_hopeless(double left, double fall, int sweeps_left) {
    for (int i = 0; i < 2 * sweeps_left / k_balance_sweeps_judged; ++i) {
      if (left < k_balance_tolerance * k_balance_tolerance) return false;
      left *= fall;
    }
    return true;
  }

  double reach_m_;
  std::array<Wrench, k_edges * k_touch_records_max> pushes_;
  std::array<double, k_edges * k_touch_records_max> inverse_squares_;
  std::array<double, k_edges * k_touch_records_max> share_{};
  std::size_t count_ = 0;
};

}  // namespace

bool can_carry(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
               const Vec3& weight_at_m) {
  const double weight = math::norm(weight_n);
  if (weight == 0) return true;
  return Balance(contacts, reach_m).carries(weight_n / weight, weight_at_m);
}

bool falls_over(std::span<const TouchRecord> contacts, const Vec3& down, double reach_m) {
  if (contacts.empty() || contacts.size() > 2) return false;
  const Vec3& arm_m = contacts.front().arm_m;
  const Vec3 axis =
      contacts.size() == 2 ? Vec3(contacts[1].arm_m - arm_m) : math::cross(arm_m, down);
  const Vec3 moves = math::cross(arm_m, axis);
  const double work = math::dot(moves, down);
  const double size = math::dot(moves, moves) + reach_m * reach_m * math::dot(axis, axis);
  constexpr double k_more_than_rounding = 1 + 1e-6;
  return work * work > k_more_than_rounding * k_balance_tolerance * k_balance_tolerance * size;
}

Contacts carrying(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
                  bool firmly) {
  const Vec3 down = weight_n / math::norm(weight_n);
  if (!firmly && falls_over(contacts, down, reach_m)) return 0;
  Balance balance(contacts, reach_m);
  if (!firmly) return balance.carries(down, Vec3::Zero()) ? balance.pushing() : 0;
  // If contacts carry the weight at the corners of a square, they also carry it inside the square.
  const Vec3 first = any_tangent(down);
  const Vec3 second = math::cross(down, first);
  Contacts pushing = 0;
  for (const Vec3& side : {first, second, Vec3(-first), Vec3(-second)}) {
    if (!balance.carries(down, k_firm * reach_m * side)) return 0;
    pushing |= balance.pushing();
  }
  return pushing;
}

}  // namespace sleight::physics
