// Can contact forces hold several bodies at once, each force in its friction cone?
//
// Idea. Forces f at m contacts hold n bodies if A f = -w: three forces and three torques for each
// body, and w their weights. The f with A f = -w are a plane; those in their cones are a convex
// set. Douglas and Rachford's splitting (J. Douglas, H. Rachford, Transactions of the American
// Mathematical Society 82, 1956; P.-L. Lions, B. Mercier, SIAM Journal on Numerical Analysis 16,
// 1979) finds a point of both, if there is one, from projections on each:
//   z += C(2 P(z) - z) - P(z),
// P the projection on the plane, C that on the cones, which is a closed form for each contact: the
// cones are round, not pyramids. P takes A A^T, which is factored once. A point of the cones that
// leaves less than a small part of each body's forces is an answer.
//
// Where no forces do, the distance of both sets stays, and the search ends soon, as its progress is
// judged. At the very limit of balance it says that nothing holds.
//
// Everything is done in a fixed order, so the answer is the same wherever it is asked. Cost: 0.05
// ms for a few bodies, milliseconds for k_held_together_max, a second for hundreds. Thread safety:
// none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

struct HeldBody {
  Vec3 weight_n = Vec3::Zero();
  double reach_m = 0;  ///< > 0; turns torques into forces
};
struct HoldingContact {
  static constexpr std::uint32_t k_fixed = UINT32_MAX;
  std::uint32_t body = 0;           ///< of the bodies
  std::uint32_t partner = k_fixed;  ///< another one, or what doesn't move
  double friction = 0;
  Vec3 normal = Vec3::UnitZ();        ///< unit, from the partner to the body
  Vec3 arm_m = Vec3::Zero();          ///< from the body's centre
  Vec3 partner_arm_m = Vec3::Zero();  ///< from the partner's, if it is a body
};

class ForceBalance {
 public:
  /// So that holds() doesn't allocate for up to so many.
  void reserve(std::size_t bodies, std::size_t contacts);
  /// Whether contact forces hold all.
  bool holds(std::span<const HeldBody> bodies, std::span<const HoldingContact> contacts);

  /// After holds(): how much was left of a body's balance, in parts of the forces on it.
  double missing(std::size_t body) const { return missing_[body]; }
  /// The force on the contact's body, if they hold.
  Vec3 force_n(std::size_t contact) const { return unit_n_ * in_cones_[contact]; }

 private:
  void factor(std::span<const HeldBody> bodies, std::span<const HoldingContact> contacts);
  /// rows = A f.
  void apply(std::span<const HeldBody> bodies, std::span<const HoldingContact> contacts,
             const std::vector<Vec3>& forces, std::vector<double>& rows) const;
  void solve(std::vector<double>& rows) const;
  double worst_missing(std::span<const HeldBody> bodies, std::span<const HoldingContact> contacts);

  double unit_n_ = 0;  ///< the greatest weight, which is the unit of all below
  // Cholesky's factor L of A A^T: by rows below the diagonal, by columns there, and 1 over that.
  std::vector<double> lower_;
  std::vector<double> upper_;
  std::vector<double> inverse_;
  std::vector<double> weights_;
  std::vector<double> rows_;
  std::vector<Vec3> z_;
  std::vector<Vec3> on_plane_;
  std::vector<Vec3> in_cones_;
  std::vector<double> pushed_;  ///< by body: the sum of its weight and of the forces on it
  std::vector<double> missing_;
};

}  // namespace sleight::physics
