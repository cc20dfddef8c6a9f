// Compares all numbers of two requests' worlds bit for bit. The sign of zero may differ.
#pragma once

#include <algorithm>
#include <tuple>
#include <type_traits>
#include <variant>

#include "worker/worlds/ball_2d/parameters.h"
#include "worker/worlds/dice/parameters.h"
#include "worker/worlds/spelling/parameters.h"

namespace sleight::worlds {

namespace ball_2d {

inline auto fields(const WorldParameters& p) {
  return std::tie(p.diameter_m, p.gravity_mps2, p.drop_height_diameters, p.collisions,
                  p.normal_sd_rad, p.restitution);
}
inline auto fields(const ConstraintParameters& p) {
  return std::tie(p.target_diameters, p.sigma_diameters, p.tolerance_diameters);
}
inline auto fields(const ProposalParameters& p) {
  return std::tie(p.change_probability, p.change_half_width_rad);
}

inline bool same(const Parameters& a, const Parameters& b) {
  return fields(a.world) == fields(b.world) && fields(a.constraint) == fields(b.constraint) &&
         fields(a.proposal) == fields(b.proposal);
}

}  // namespace ball_2d

namespace spelling {

inline auto fields(const WorldParameters& p) {
  return std::tie(p.bin_m, p.partition_m, p.partition_height_m, p.box_height_m, p.drop_height_m,
                  p.vertex_sd_m, p.dome_m, p.ball_diameter_m, p.density_kgpm3, p.drop_interval_s,
                  p.restitution, p.friction, p.gravity_mps2, p.bounce_end, p.rest_speed,
                  p.rest_time, p.time_limit_s);
}
inline auto fields(const ProposalParameters& p) {
  return std::tie(p.kernel, p.change_all, p.change_vertices, p.change_ball, p.disable_balls,
                  p.enable_balls, p.aim_ball, p.scatter_ball, p.solo_steps, p.vertex_probability,
                  p.vertex_sd_m, p.ball_sd_m, p.flip_probability);
}

inline bool same(const Parameters& a, const Parameters& b) {
  return fields(a.world) == fields(b.world) && a.pattern == b.pattern &&
         a.constraint.log_lambda == b.constraint.log_lambda &&
         fields(a.proposal) == fields(b.proposal);
}

}  // namespace spelling

namespace dice {

inline auto coefficients(const Quat& q) {
  return std::tuple(q.w(), q.x(), q.y(), q.z());
}
inline auto fields(const TableParameters& p) {
  return std::tie(p.spacing_m, p.columns, p.rows, p.height_sd_m, p.restitution.low,
                  p.restitution.high, p.friction.low, p.friction.high);
}
inline auto fields(const ProposalParameters& p) {
  return std::tie(p.change_all, p.change_die, p.change_start, p.change_control, p.change_contact,
                  p.position_m, p.velocity_mps, p.spin_radps, p.turn_rad, p.height_m, p.restitution,
                  p.friction, p.halvings);
}

inline bool same_start(const DieStart& a, const DieStart& b) {
  return a.position_m == b.position_m && a.position_sd_m == b.position_sd_m &&
         a.orientation == b.orientation &&
         coefficients(a.fixed_orientation) == coefficients(b.fixed_orientation) &&
         a.velocity_mps == b.velocity_mps && a.velocity_sd_mps == b.velocity_sd_mps &&
         a.spin_radps == b.spin_radps && a.spin_sd_radps == b.spin_sd_radps &&
         a.start_s == b.start_s;
}

inline bool same_world(const WorldParameters& a, const WorldParameters& b) {
  return std::tie(a.side_m, a.density_kgpm3, a.dice_restitution, a.dice_friction, a.gravity_mps2,
                  a.time_max_s) == std::tie(b.side_m, b.density_kgpm3, b.dice_restitution,
                                            b.dice_friction, b.gravity_mps2, b.time_max_s) &&
         fields(a.table) == fields(b.table) &&
         std::equal(a.dice.begin(), a.dice.end(), b.dice.begin(), b.dice.end(), same_start);
}

inline bool same_wanted(const Place& a, const Place& b) {
  return a.centre_m == b.centre_m;
}
inline bool same_wanted(const Region& a, const Region& b) {
  return a.low_m == b.low_m && a.high_m == b.high_m;
}
inline bool same_wanted(const FaceDirection& a, const FaceDirection& b) {
  return a.face == b.face && a.direction == b.direction;
}
inline bool same_wanted(const Turn& a, const Turn& b) {
  return coefficients(a.orientation) == coefficients(b.orientation);
}
inline bool same_wanted(const Velocity& a, const Velocity& b) {
  return a.velocity_mps == b.velocity_mps;
}
inline bool same_wanted(const RestBefore& a, const RestBefore& b) {
  return a.time_s == b.time_s;
}

inline bool same_goal(const Goal& a, const Goal& b) {
  const auto same = [](const auto& one, const auto& other) {
    if constexpr (std::is_same_v<decltype(one), decltype(other)>) {
      return same_wanted(one, other);
    } else {
      return false;
    }
  };
  return a.die == b.die && a.at_s == b.at_s && std::visit(same, a.wanted, b.wanted) &&
         a.sigma == b.sigma && a.tolerance == b.tolerance;
}

inline bool same(const Parameters& a, const Parameters& b) {
  return same_world(a.world, b.world) && a.numbering == b.numbering &&
         std::equal(a.goals.begin(), a.goals.end(), b.goals.begin(), b.goals.end(), same_goal) &&
         fields(a.proposal) == fields(b.proposal);
}

}  // namespace dice

}  // namespace sleight::worlds
