// Tests whether contacts can carry the weight of one body.
//
// Idea. The contacts push along their normals, with friction cones that are approximated from
// inside by pyramids with four edges. Non-negative least squares by coordinate descent finds how
// strongly each edge pushes. The contacts carry the weight if the sums of forces and torques are
// zero to within k_balance_tolerance times the weight. force_balance.h does the same for several
// bodies at once.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "worker/physics/contact/touch_record.h"

namespace sleight::physics {

/// A set of a body's contacts, as bits.
using Contacts = std::uint32_t;

/// Whether contacts can carry a weight that acts at `weight_at_m` from the body's centre. `reach_m`
/// converts torques to forces. REQUIRES: k_touch_records_max contacts at most.
bool can_carry(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
               const Vec3& weight_at_m = Vec3::Zero());

/// Returns the contacts that push when the contacts carry a weight at the centre; an empty set if
/// they can't carry it. `firmly`: the contacts must also carry the weight if the centre moves by a
/// little (k_firm) to any side. REQUIRES: weight > 0, and the conditions of can_carry.
Contacts carrying(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
                  bool firmly);

/// Quickly tests whether one or two contacts certainly don't carry a weight at the centre. When the
/// body turns about the line through two contacts, or about one contact in the direction in which
/// the weight falls, no push does work. The weight's work, divided by the size of that motion, is a
/// lower bound for the imbalance. `down`: unit vector.
bool falls_over(std::span<const TouchRecord> contacts, const Vec3& down, double reach_m);

}  // namespace sleight::physics
