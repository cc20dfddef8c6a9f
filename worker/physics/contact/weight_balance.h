// Can contacts carry the weight of one body?
//
// Idea. The contacts push along their normals, each with friction in a cone. The cones are pyramids
// of four edges, which lie inside of them. Non-negative least squares by coordinate descent finds
// how much each edge pushes; the contacts carry the weight if sums of forces and of torques are
// zero to within k_balance_tolerance of it. force_balance.h is the same of several bodies at once.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "worker/physics/contact/touch_record.h"

namespace sleight::physics {

/// Some of a body's contacts, as bits.
using Contacts = std::uint32_t;

/// Whether contacts can carry a weight that acts at a place from the body's centre. `reach_m` turns
/// torques into forces. REQUIRES: k_touch_records_max contacts at most.
bool can_carry(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
               const Vec3& weight_at_m = Vec3::Zero());

/// The contacts that push when they carry a weight at the centre; none if they can't. `firmly`:
/// they could also if the centre were a little (k_firm) to any side. REQUIRES: weight > 0, and as
/// can_carry.
Contacts carrying(std::span<const TouchRecord> contacts, const Vec3& weight_n, double reach_m,
                  bool firmly);

/// Whether one or two contacts certainly don't carry a weight at the centre, which is quickly seen:
/// when the body turns about the line through them, or about the one contact towards which the
/// weight falls, no push does work. The work of the weight meanwhile, over the size of that motion,
/// is a lower bound of what no push carries. `down`: unit.
bool falls_over(std::span<const TouchRecord> contacts, const Vec3& down, double reach_m);

}  // namespace sleight::physics
