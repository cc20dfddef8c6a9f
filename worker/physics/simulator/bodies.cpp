#include "worker/physics/simulator/bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "worker/physics/motion/invariants.h"

namespace sleight::physics {
namespace {

/// A valid inertia for a fixed body, whose own inertia may be invalid. Affects no result.
Inertia inertia_of_fixed() {
  return {.mass_kg = 1, .principal_kgm2 = Vec3::Ones(), .symmetry = InertiaSymmetry::spherical};
}

double wrapped(double x, double period) {
  if (period == 0 || (x > 0 && x < 0.99 * period)) return x;
  const double inside = x - std::floor(x / period) * period;
  return inside < period ? inside : 0;  // rounding can return the period itself
}

}  // namespace

Bodies::Bodies(const Scene& scene) : scene_(scene) {
  const std::size_t count = scene_.bodies.size();
  flights_.resize(count);
  segments_.resize(count);
  started_.assign(count, 0);
  turning_.resize(count);
  turns_.assign(count, 0);
  constants_.reserve(count);
  points_.reserve(count);
  HullOfShape hull_of_shape;
  for (const BodyDescription& body : scene_.bodies) {
    BodyConstants constants{.material = body.material,
                            .fixed = body.fixed,
                            .first_part = static_cast<std::uint32_t>(parts_.size()),
                            .group = body.group,
                            .inertia = body.fixed ? inertia_of_fixed() : body.inertia,
                            .rigid_mass = body.fixed ? RigidMass{} : rigid_mass(body.inertia)};
    if (body.fixed) fixed_.push_back({static_cast<std::uint32_t>(constants_.size())});
    if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
      constants.reach_m = sphere->radius_m;
      if (!body.fixed)
        constants.sphere_mass =
            sphere_mass(body.inertia.mass_kg, sphere->radius_m, body.inertia.principal_kgm2.x());
      points_.emplace_back(Vec3::Zero());
      parts_.push_back(points_.back().view());
    } else {
      const Compound& compound = *std::get<std::shared_ptr<const Compound>>(body.shape);
      constants.is_sphere = false;
      only_spheres_ = false;
      constants.reach_m = compound.r_outer_m();
      constants.part_count = static_cast<std::uint32_t>(compound.size());
      constants.has_round_parts = !compound.round_parts.empty();
      for (std::size_t part = 0; part < compound.size(); ++part)
        parts_.push_back(compound.view(part));
      if (compound.round_parts.size() > 1) constants.hull = hull_index(compound, hull_of_shape);
      if (constants.inertia.symmetry != InertiaSymmetry::general)
        constants.axis = axis_of_revolution(compound).value_or(Vec3::Zero());
    }
    // Allocate a general body's track now, not when the body starts.
    if (constants.inertia.symmetry == InertiaSymmetry::general) {
      turning_[constants_.size()].track.restart({}, constants.inertia);
    }
    constants_.push_back(constants);
  }
  all_meet_ = fixed_.empty() && !scene_.filter.any();
  periodic_ = scene_.period_m[0] > 0 || scene_.period_m[1] > 0 || scene_.period_m[2] > 0;
}

std::uint32_t Bodies::hull_index(const Compound& compound, HullOfShape& known) {
  const auto found = std::ranges::find(known, &compound, &HullOfShape::value_type::first);
  if (found != known.end()) return found->second;
  std::uint32_t index = BodyConstants::k_no_hull;
  if (auto hull = hull_of(compound)) {
    index = static_cast<std::uint32_t>(hulls_.size());
    made_hulls_.push_back(std::make_unique<const RoundPiece>(*std::move(hull)));
    hulls_.push_back(made_hulls_.back()->view());
  }
  known.emplace_back(&compound, index);
  return index;
}

std::string Bodies::name(BodyId body) const {
  const std::string& given = scene_.bodies[body].name;
  return given.empty() ? fmt::format("body {}", body) : fmt::format("body '{}'", given);
}

// ---- segments -----------------------------------------------------------------------------------

Segment Bodies::segment_of_start(const StartState& start, Tick tick) const {
  return {.flight = {.begin = tick,
                     .position_m = start.pose.position_m,
                     .velocity_mps = start.twist.velocity_mps,
                     .acceleration_mps2 = scene_.gravity_mps2,
                     .orientation = math::normalized(start.pose.orientation),
                     .angular_velocity_radps = start.twist.angular_velocity_radps}};
}

Segment Bodies::segment_after(BodyId body, Tick tick, const Vec3& position_m, const Twist& twist) {
  return {.flight = {.begin = tick,
                     .position_m = position_m,
                     .velocity_mps = twist.velocity_mps,
                     .acceleration_mps2 = scene_.gravity_mps2,
                     .orientation = orientation_at(body, tick),
                     .angular_velocity_radps = twist.angular_velocity_radps}};
}

Vec3 Bodies::wrapped_m(const Vec3& place_m) const {
  Vec3 inside_m;
  for (int i = 0; i < 3; ++i)
    inside_m[i] = wrapped(place_m[i], scene_.period_m[static_cast<std::size_t>(i)]);
  return inside_m;
}

void Bodies::place(BodyId body, const Segment& segment) {
  Segment& now = segments_[body];
  now = segment;
  now.flight.position_m = wrapped_m(now.flight.position_m);
  flights_[body] = {.position_m = now.flight.position_m,
                    .velocity_mps = now.flight.velocity_mps,
                    .begin = now.flight.begin,
                    .radius_m = constants_[body].is_sphere && now.mode == MotionMode::free
                                    ? constants_[body].reach_m
                                    : 0};
  turns_[body] = is_zero(now.flight.angular_velocity_radps) ? 0 : 1;
  if (only_spheres_) return;
  Turning& turning = turning_[body];
  turning.placed_at = Tick{-1};
  if (constants_[body].is_sphere) return;
  if (in_contact(now)) {
    turning.bounds = contact_rotation_bounds(now);
    return;
  }
  turning.track.restart(now.flight, constants_[body].inertia);
  turning.bounds = rotation_bounds(now.flight, constants_[body].inertia);
}

void Bodies::begin(BodyId body, const Segment& segment) {
  place(body, segment);
  started_[body] = 1;
  stays_on_nothing(body);
}

void Bodies::catch_up(BodyId body) const {
  const Flight& flight = flights_[body];
  if (flight.radius_m == 0) return;
  FreeFlight& whole = segments_[body].flight;
  whole.begin = flight.begin;
  whole.position_m = flight.position_m;
  whole.velocity_mps = flight.velocity_mps;
}

// ---- at a tick ----------------------------------------------------------------------------------

Quat Bodies::orientation_at(BodyId body, Tick tick) {
  const FreeFlight& flight = segment(body).flight;
  if (constants_[body].is_sphere)
    return math::normalized(orientation_of(segment(body), constants_[body].inertia, tick));
  if (turning_[body].placed_at == tick) return turning_[body].orientation;
  const bool turns = !is_zero(flight.angular_velocity_radps) ||
                     !is_zero(segment(body).angular_acceleration_radps2);
  if (!turns) return flight.orientation;
  if (in_contact(segment(body)))
    return math::normalized(orientation_of(segment(body), constants_[body].inertia, tick));
  return math::normalized(turning_[body].track.orientation_at(tick));
}

Pose Bodies::pose_at(BodyId body, Tick tick) {
  return {.position_m = physics::position_at(segment(body).flight, tick),
          .orientation = orientation_at(body, tick)};
}

Twist Bodies::twist_at(BodyId body, Tick tick) {
  const FreeFlight& flight = segment(body).flight;
  if (in_contact(segment(body))) {
    const Vec3& half_way = supports_[body].half_way;
    if (is_zero(half_way)) return twist_of(segment(body), constants_[body].inertia, tick);
    return twist_over_edge(round_body(body), segment(body), half_way, scene_.gravity_mps2, tick);
  }
  const bool constant = constants_[body].inertia.symmetry == InertiaSymmetry::spherical ||
                        is_zero(flight.angular_velocity_radps);
  if (!constant && turning_[body].placed_at == tick) {
    return {.velocity_mps = turning_[body].placed.velocity_mps,
            .angular_velocity_radps = turning_[body].placed.angular_velocity_radps};
  }
  return {.velocity_mps = velocity_at(flight, tick),
          .angular_velocity_radps = constant ? flight.angular_velocity_radps
                                             : turning_[body].track.angular_velocity_at(tick)};
}

double Bodies::kinetic_energy_j(Tick tick) {
  double sum_j = 0;
  for (BodyId body{}; body < size(); ++body) {
    if (!started(body)) continue;
    sum_j += physics::kinetic_energy_j(constants_[body].inertia, orientation_at(body, tick),
                                       twist_at(body, tick));
  }
  return sum_j;
}

const MovingPiece& Bodies::moving_at(BodyId body, Tick tick) {
  Turning& turning = turning_[body];
  if (turning.placed_at == tick) return turning.placed;
  const Twist twist = twist_at(body, tick);
  const bool sphere = constants_[body].is_sphere;
  if (!sphere) turning.orientation = orientation_at(body, tick);
  const Vec3 place_m = physics::position_at(segment(body).flight, tick);
  turning.placed = {
      .radius_m = sphere ? constants_[body].reach_m : 0,
      .pose = sphere ? PlacedPose{.position_m = place_m}
                     : placed({.position_m = place_m, .orientation = turning.orientation}),
      .coordinates_m = coordinates_m_max(segment(body).flight, tick),
      .velocity_mps = twist.velocity_mps,
      .acceleration_mps2 = segment(body).flight.acceleration_mps2,
      .angular_velocity_radps = twist.angular_velocity_radps,
      .turning_acceleration_mps2 =
          sphere ? 0 : turning_acceleration_mps2_max(turning.bounds, constants_[body].reach_m),
      .turns_evenly = constants_[body].inertia.symmetry == InertiaSymmetry::spherical &&
                      is_zero(segment(body).angular_acceleration_radps2),
      .reach_m = sphere ? 0 : constants_[body].reach_m};
  turning.placed_at = tick;
  return turning.placed;
}

MovingPiece Bodies::part_at(BodyId body, std::uint32_t part, Tick tick) {
  MovingPiece piece = moving_at(body, tick);
  piece.view = &parts_[constants_[body].first_part + part];
  if (constants_[body].is_sphere) piece.angular_velocity_radps = Vec3::Zero();
  return piece;
}

std::optional<MovingPiece> Bodies::hull_at(BodyId body, Tick tick) {
  MovingPiece piece = part_at(body, 0, tick);
  if (constants_[body].part_count == 1) return piece;
  if (constants_[body].hull == BodyConstants::k_no_hull) return std::nullopt;
  piece.view = &hulls_[constants_[body].hull];
  return piece;
}

RigidImpactBody Bodies::rigid_body(BodyId body, Tick tick) {
  return {.mass = constants_[body].rigid_mass,
          .pose = pose_at(body, tick),
          .twist = twist_at(body, tick)};
}

}  // namespace sleight::physics
