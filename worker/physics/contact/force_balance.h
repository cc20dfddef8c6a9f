// Tests whether contact forces can hold several bodies at once. Each force must be in its friction
// cone.
//
// Idea. Forces f at m contacts hold n bodies if A f = -w. A f contains three forces and three
// torques per body; w contains the weights. The f with A f = -w form an affine plane. The f inside
// their cones form a convex set. Douglas and Rachford's splitting (Douglas and Rachford,
// Transactions of the American Mathematical Society 82, 1956, and Lions and Mercier, SIAM Journal
// on Numerical Analysis 16, 1979) finds a point that is in both sets, if there is one. It iterates
//   z += C(2 P(z) - z) - P(z).
// P projects onto the plane. P needs A A^T, which is factored once. C projects onto the cones. C
// has a closed form for each contact, because the cones are round, not pyramids. The search accepts
// a point of the cones whose imbalance is below a small fraction of the forces on each body.
//
// If no forces hold the bodies, the distance between the two sets stays positive. The search
// monitors its progress, so it then stops early. At the very limit of balance, holds()
// returns false.
//
// The order of all operations is fixed, so the same input always gives the same answer. A call
// takes 0.05 ms for a few bodies, milliseconds for k_held_together_max bodies, and a second for
// hundreds. Thread safety: none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

struct HeldBody {
  Vec3 weight_n = Vec3::Zero();
  double reach_m = 0;  ///< > 0; converts torques to forces
};
struct HoldingContact {
  static constexpr std::uint32_t k_fixed = UINT32_MAX;
  std::uint32_t body = 0;           ///< index in the bodies
  std::uint32_t partner = k_fixed;  ///< index of another body, or k_fixed
  double friction = 0;
  Vec3 normal = Vec3::UnitZ();        ///< unit, from the partner to the body
  Vec3 arm_m = Vec3::Zero();          ///< from the body's centre
  Vec3 partner_arm_m = Vec3::Zero();  ///< from the partner's centre, if it is a body
};

class ForceBalance {
 public:
  /// Reserves memory, so that holds() allocates none up to these numbers of bodies and contacts.
  void reserve(std::size_t bodies, std::size_t contacts);
  bool holds(std::span<const HeldBody> bodies, std::span<const HoldingContact> contacts);

  /// After holds(): a body's imbalance, as a fraction of the forces on the body.
  double missing(std::size_t body) const { return missing_[body]; }
  /// Returns the force on the contact's body. Call after holds() has returned true.
  Vec3 force_n(std::size_t contact) const { return unit_n_ * in_cones_[contact]; }

 private:
  void factor(std::span<const HeldBody> bodies, std::span<const HoldingContact> contacts);
  /// rows = A f.
  void apply(std::span<const HeldBody> bodies, std::span<const HoldingContact> contacts,
             const std::vector<Vec3>& forces, std::vector<double>& rows) const;
  void solve(std::vector<double>& rows) const;
  double worst_missing(std::span<const HeldBody> bodies, std::span<const HoldingContact> contacts);

  double unit_n_ = 0;  ///< greatest weight; the unit of all forces below
  // The Cholesky factor L of A A^T. lower_ has the part below the diagonal by rows, upper_ by
  // columns. inverse_ has the inverse of the diagonal.
  std::vector<double> lower_;
  std::vector<double> upper_;
  std::vector<double> inverse_;
  std::vector<double> weights_;
  std::vector<double> rows_;
  std::vector<Vec3> z_;
  std::vector<Vec3> on_plane_;
  std::vector<Vec3> in_cones_;
  std::vector<double> pushed_;  ///< by body: sum of the magnitudes of its weight and contact forces
  std::vector<double> missing_;
};

}  // namespace sleight::physics
