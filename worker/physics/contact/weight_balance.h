// Tests whether contacts can carry the weight of one body.
//
// Idea. Each contact pushes with a force in its friction cone. An inscribed pyramid with four edges
// approximates the cone. Non-negative least squares by coordinate descent finds how strongly each
// edge pushes. The contacts carry the weight if the sums of forces and torques are zero to within
// k_balance_tolerance times the weight. force_balance.h tests several bodies at once.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "worker/physics/contact/touch_record.h"

namespace sleight::physics {

/// A set of a body's contacts, as bits.
using Contacts = std::uint32_t;

/// The weight acts at `weight_at_m`, relative to the body's centre. `reach_m` converts torques to
/// forces. REQUIRES: k_touch_records_max contacts at most.
bool can_carry(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
               const Vec3& weight_at_m = Vec3::Zero());

/// Returns the contacts that push to carry a weight at the centre. If the contacts can't carry it,
/// returns an empty set. `firmly`: the contacts must also carry the weight if the centre moves a
/// little (k_firm) to any side. REQUIRES: weight > 0, and the conditions of can_carry.
Contacts carrying(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
                  bool firmly);

/// Quickly tests whether one or two contacts certainly don't carry a weight at the centre. Turn the
/// body about the line through two contacts, or about one contact in the direction in which the
/// weight falls. No push does work in this motion. The weight's work, divided by the size of the
/// motion, is a lower bound for the imbalance. `down`: unit vector.
bool falls_over(std::span<const TouchRecord> contacts, const Vec3& down, double reach_m);

}  // namespace sleight::physics
