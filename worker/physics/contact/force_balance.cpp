#include "worker/physics/contact/force_balance.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "common/math/vector.h"
#include "worker/physics/contact/resting.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

/// Relative size of the term that is added to the diagonal. The term is needed if a body's contacts
/// leave a rotation free.
constexpr double k_ridge = 1e-9;

/// Projects a force onto a contact's friction cone.
Vec3 in_cone(const HoldingContact& contact, const Vec3& force) {
  const double along = dot(contact.normal, force);
  const Vec3 across = force - along * contact.normal;
  const double size = norm(across);
  const double mu = contact.friction;
  if (size <= mu * along) return force;
  if (mu * size <= -along) return Vec3::Zero();
  const double load = (along + mu * size) / (1 + mu * mu);
  return load * contact.normal + (mu * load / size) * across;
}

/// Each contact has three columns of A. Columns is the part of them for one of the contact's two
/// bodies: force and torque.
struct Columns {
  std::size_t row;
  double sign;
  Vec3 lever;  ///< arm / reach
};
template <class Visit>
void for_each_side(std::span<const HeldBody> bodies, const HoldingContact& contact,
                   const Visit& visit) {
  const Vec3 lever = contact.arm_m / bodies[contact.body].reach_m;
  visit(Columns{6 * std::size_t{contact.body}, 1, lever});
  if (contact.partner == HoldingContact::k_fixed) return;
  const Vec3 other = contact.partner_arm_m / bodies[contact.partner].reach_m;
  visit(Columns{6 * std::size_t{contact.partner}, -1, other});
}

}  // namespace

void ForceBalance::reserve(std::size_t bodies, std::size_t contacts) {
  const std::size_t size = 6 * bodies;
  lower_.reserve(size * size);
  upper_.reserve(size * size);
  for (std::vector<double>* rows : {&inverse_, &weights_, &rows_})
    rows->reserve(size);
  for (std::vector<Vec3>* forces : {&z_, &on_plane_, &in_cones_})
    forces->reserve(contacts);
  pushed_.reserve(bodies);
  missing_.reserve(bodies);
}

void ForceBalance::factor(std::span<const HeldBody> bodies,
                          std::span<const HoldingContact> contacts) {
  const std::size_t size = 6 * bodies.size();
  lower_.assign(size * size, 0);
  // Each contact adds G G^T to A A^T. For each of its two bodies, G has the block +-(1; [lever]).
  for (const HoldingContact& contact : contacts) {
    for_each_side(bodies, contact, [&](const Columns& a) {
      for_each_side(bodies, contact, [&](const Columns& b) {
        if (b.row > a.row) return;
        for (int column = 0; column < 3; ++column) {
          const Vec3 unit = Vec3::Unit(column);
          const Vec3 turn_a = cross(a.lever, unit);
          const Vec3 turn_b = cross(b.lever, unit);
          for (std::size_t i = 0; i < 6; ++i) {
            const auto at = [](const Vec3& push, const Vec3& turn, std::size_t k) {
              return k < 3 ? push[static_cast<int>(k)] : turn[static_cast<int>(k - 3)];
            };
            for (std::size_t j = 0; j < 6; ++j)
              lower_[(a.row + i) * size + b.row + j] +=
                  a.sign * b.sign * at(unit, turn_a, i) * at(unit, turn_b, j);
          }
        }
      });
    });
  }
  double greatest = 0;
  for (std::size_t i = 0; i < size; ++i)
    greatest = std::max(greatest, lower_[i * size + i]);
  for (std::size_t i = 0; i < size; ++i)
    lower_[i * size + i] += k_ridge * greatest;
  // Work column by column, so that no step of an inner loop waits for the previous step's sum.
  upper_.assign(size * size, 0);
  inverse_.assign(size, 0);
  for (std::size_t k = 0; k < size; ++k) {
    const double root = std::sqrt(std::max(lower_[k * size + k], k_ridge * k_ridge * greatest));
    inverse_[k] = 1 / root;
    double* const column = &upper_[k * size];
    for (std::size_t i = k + 1; i < size; ++i)
      column[i] = lower_[i * size + k] * inverse_[k];
    for (std::size_t i = k + 1; i < size; ++i) {
      lower_[i * size + k] = column[i];
      double* const row = &lower_[i * size];
      const double factor = column[i];
      if (factor == 0) continue;
      for (std::size_t j = k + 1; j <= i; ++j)
        row[j] -= factor * column[j];
    }
  }
}

void ForceBalance::apply(std::span<const HeldBody> bodies, std::span<const HoldingContact> contacts,
                         const std::vector<Vec3>& forces, std::vector<double>& rows) const {
  std::ranges::fill(rows, 0.0);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    for_each_side(bodies, contacts[c], [&](const Columns& side) {
      const Vec3 turn = cross(side.lever, forces[c]);
      for (int i = 0; i < 3; ++i) {
        rows[side.row + static_cast<std::size_t>(i)] += side.sign * forces[c][i];
        rows[side.row + 3 + static_cast<std::size_t>(i)] += side.sign * turn[i];
      }
    });
  }
}

void ForceBalance::solve(std::vector<double>& rows) const {
  const std::size_t size = rows.size();
  double* const x = rows.data();
  for (std::size_t k = 0; k < size; ++k) {
    const double value = x[k] * inverse_[k];
    x[k] = value;
    const double* const column = &upper_[k * size];
    for (std::size_t i = k + 1; i < size; ++i)
      x[i] -= column[i] * value;
  }
  for (std::size_t i = size; i-- > 0;) {
    const double value = x[i] * inverse_[i];
    x[i] = value;
    const double* const row = &lower_[i * size];
    for (std::size_t k = 0; k < i; ++k)
      x[k] -= row[k] * value;
  }
}

double ForceBalance::worst_missing(std::span<const HeldBody> bodies,
                                   std::span<const HoldingContact> contacts) {
  apply(bodies, contacts, in_cones_, rows_);
  for (std::size_t b = 0; b < bodies.size(); ++b)
    pushed_[b] = norm(Vec3(weights_[6 * b], weights_[6 * b + 1], weights_[6 * b + 2]));
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const double size = norm(in_cones_[c]);
    pushed_[contacts[c].body] += size;
    if (contacts[c].partner != HoldingContact::k_fixed) pushed_[contacts[c].partner] += size;
  }
  double worst = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    double sum = 0;
    for (std::size_t i = 6 * b; i < 6 * b + 6; ++i) {
      const double left = rows_[i] + weights_[i];
      sum += left * left;
    }
    // The factor 0.5 makes the unit a standing body's weight: the weight and the push that carries
    // it are equal.
    missing_[b] = std::sqrt(sum) / (0.5 * pushed_[b]);
    worst = std::max(worst, missing_[b]);
  }
  return worst;
}

bool ForceBalance::holds(std::span<const HeldBody> bodies,
                         std::span<const HoldingContact> contacts) {
  for (const HoldingContact& contact : contacts) {
    CHECK(contact.body < bodies.size());
    CHECK(contact.partner == HoldingContact::k_fixed || contact.partner < bodies.size());
  }
  const std::size_t size = 6 * bodies.size();
  unit_n_ = 0;
  for (const HeldBody& body : bodies)
    unit_n_ = std::max(unit_n_, norm(body.weight_n));
  missing_.assign(bodies.size(), 0);
  in_cones_.assign(contacts.size(), Vec3::Zero());
  if (!(unit_n_ > 0)) return true;
  weights_.assign(size, 0);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    for (int i = 0; i < 3; ++i)
      weights_[6 * b + static_cast<std::size_t>(i)] = bodies[b].weight_n[i] / unit_n_;
  }
  rows_.assign(size, 0);
  pushed_.assign(bodies.size(), 0);
  z_.assign(contacts.size(), Vec3::Zero());
  on_plane_.assign(contacts.size(), Vec3::Zero());
  factor(bodies, contacts);
  double earlier = worst_missing(bodies, contacts);
  for (int round = 1; round <= k_held_rounds_max; ++round) {
    // Project z onto the plane: z - A^T (A A^T)^-1 (A z + w).
    apply(bodies, contacts, z_, rows_);
    for (std::size_t i = 0; i < size; ++i)
      rows_[i] += weights_[i];
    solve(rows_);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      Vec3 step = Vec3::Zero();
      for_each_side(bodies, contacts[c], [&](const Columns& side) {
        const double* const row = &rows_[side.row];
        const Vec3 push(row[0], row[1], row[2]);
        const Vec3 turn(row[3], row[4], row[5]);
        // The transpose of [lever] maps `turn` to turn x lever.
        step += side.sign * (push + cross(turn, side.lever));
      });
      on_plane_[c] = z_[c] - step;
      in_cones_[c] = in_cone(contacts[c], Vec3(2 * on_plane_[c] - z_[c]));
      z_[c] += in_cones_[c] - on_plane_[c];
    }
    if (round % 4 != 0 && round % k_held_rounds_judged != 0) continue;
    const double worst = worst_missing(bodies, contacts);
    if (worst <= k_balance_tolerance) return true;
    if (round % k_held_rounds_judged != 0) continue;
    // Give up if the imbalance would stay too large even if it fell twice as fast as now.
    const double fall = worst / earlier;
    double later = worst;
    for (int i = 0; i < 2 * (k_held_rounds_max - round) / k_held_rounds_judged; ++i) {
      if (later <= k_balance_tolerance) break;
      later *= fall;
    }
    if (later > k_balance_tolerance) return false;
    earlier = worst;
  }
  return false;
}

}  // namespace sleight::physics
