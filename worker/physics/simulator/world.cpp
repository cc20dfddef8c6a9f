#include "worker/physics/simulator/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "worker/physics/motion/invariants.h"

namespace sleight::physics {
namespace {

double wrapped(double x, double period) {
  if (period == 0 || (x > 0 && x < 0.99 * period)) return x;
  const double inside = x - std::floor(x / period) * period;
  return inside < period ? inside : 0;  // rounding can give the period itself
}

/// Whether some of a box is not above all that lies under it.
bool surface_reaches(SplineSurface& surface, const Box& box) {
  const auto low = [&](std::size_t axis) { return double{box.low_m[axis]}; };
  const auto high = [&](std::size_t axis) { return double{box.high_m[axis]}; };
  return low(2) <= surface.bounds_in(low(0), high(0), low(1), high(1)).top_m;
}

}  // namespace

World::World(const Scene& scene, bool record, std::size_t segments_reserved)
    : scene_(scene), statics_(scene_), record_(record) {
  const std::size_t count = scene_.bodies.size();
  flights_.resize(count);
  segments_.resize(count);
  started_.assign(count, 0);
  turning_.resize(count);
  const bool contacts_last = scene_.slow.separation_speed_mps > 0 && statics_.feature_count() > 0;
  supports_.resize(contacts_last ? count : 0);
  has_modes_ = contacts_last;
  const double pull_mps2 = math::norm(scene_.gravity_mps2);
  if (contacts_last && pull_mps2 > 0)
    alone_for_ = ticks_after(k_bounces_alone * 2 * scene_.slow.separation_speed_mps / pull_mps2);
  constants_.reserve(count);
  points_.reserve(count);
  HullOfShape hull_of_shape;
  for (const BodyDescription& body : scene_.bodies) {
    BodyConstants constants{.material = body.material,
                            .first_part = static_cast<std::uint32_t>(parts_.size()),
                            .inertia = body.inertia,
                            .rigid_mass = rigid_mass(body.inertia)};
    if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
      constants.reach_m = sphere->radius_m;
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
      if (body.inertia.symmetry != InertiaSymmetry::general)
        constants.axis = axis_of_revolution(compound).value_or(Vec3::Zero());
    }
    // What a track of a general body needs is allocated now rather than when the body starts.
    if (constants.inertia.symmetry == InertiaSymmetry::general) {
      has_modes_ = true;
      turning_[constants_.size()].track.restart({}, constants.inertia);
    }
    constants_.push_back(constants);
  }
  const double bounce_s = pull_mps2 > 0 ? 2 * scene_.slow.separation_speed_mps / pull_mps2 : 1;
  resting_.reset(count, scene_.slow, ticks_after(k_jam_bounces * bounce_s));
  recent_.reset(scene_.slow.separation_speed_mps > 0 ? count : 0);
  changed_.reserve(count);
  searches_.reserve(count);
  collided_.resize(count);
  recording_.reset(record_ ? count : 0, segments_reserved);
  periodic_ = scene_.period_m[0] > 0 || scene_.period_m[1] > 0 || scene_.period_m[2] > 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double period_m = scene_.period_m[axis];
    if (period_m == 0) continue;
    images_.period_m.set(axis, period_m);
    images_.half_m.set(axis, 0.5 * period_m);
    images_.middle_m.set(axis, 0.9 * period_m);
    images_.sure_m.set(axis, 0.35 * period_m);
  }
  for (std::size_t i = 0; i < scene_.surfaces.size(); ++i) {
    const StaticSurface& surface = scene_.surfaces[i];
    surfaces_.push_back(
        {name_of_static("surface", surface.name, i), SplineSurface(surface), {}, {}});
    surfaces_.back().near.resize(parts_.size());
    for (const ConvexView& part : parts_) {
      std::optional<BoxLattice> lattice = BoxLattice::of(part, surface.point_spacing_m);
      CHECK(lattice.has_value());
      surfaces_.back().lattices.push_back(*lattice);
    }
  }
  has_statics_ = statics_.feature_count() > 0 || statics_.piece_count() > 0 || !surfaces_.empty();
  plain_spheres_ = only_spheres_ && !resting_.enabled() && !recent_.enabled() &&
                   scene_.contacts.materials() == 1 &&
                   scene_.contacts.between({}, {}).friction == 0;
  turns_.assign(count, 0);
}

std::uint32_t World::hull_index(const Compound& compound, HullOfShape& known) {
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

std::string World::name(std::uint32_t body) const {
  const std::string& given = scene_.bodies[body].name;
  return given.empty() ? fmt::format("body {}", body) : fmt::format("body '{}'", given);
}

// ---- segments -----------------------------------------------------------------------------------

Segment World::segment_of_start(const StartState& start, Tick tick) const {
  return {.flight = {.begin = tick,
                     .position_m = start.pose.position_m,
                     .velocity_mps = start.twist.velocity_mps,
                     .acceleration_mps2 = scene_.gravity_mps2,
                     .orientation = math::normalized(start.pose.orientation),
                     .angular_velocity_radps = start.twist.angular_velocity_radps}};
}

Vec3 World::wrapped_m(const Vec3& place_m) const {
  Vec3 inside_m;
  for (int i = 0; i < 3; ++i)
    inside_m[i] = wrapped(place_m[i], scene_.period_m[static_cast<std::size_t>(i)]);
  return inside_m;
}

void World::place(std::uint32_t body, const Segment& segment) {
  found_.tick = Tick{-1};
  hull_look_.tick = Tick{-1};
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

void World::begin_segment(std::uint32_t body, const Segment& segment, const EventKey& cause) {
  place(body, segment);
  if (places_.enabled()) note_place(body);
  started_[body] = 1;
  if (!supports_.empty()) {
    supports_[body].count = 0;
    supports_[body].end = k_never;
  }
  if (record_) recording_.append({body}, segments_[body], cause);
  if (history_builder_) history_builder_->begins(body);
}

Segment World::segment_after(std::uint32_t body, Tick tick, const Vec3& position_m,
                             const Twist& twist) {
  return {.flight = {.begin = tick,
                     .position_m = position_m,
                     .velocity_mps = twist.velocity_mps,
                     .acceleration_mps2 = scene_.gravity_mps2,
                     .orientation = orientation_at(body, tick),
                     .angular_velocity_radps = twist.angular_velocity_radps}};
}

MovingPoint World::centre_at(std::uint32_t body, Tick tick) const {
  const FreeFlight& flight = segments_[body].flight;
  return {.position_m = position_at(flight, tick),
          .velocity_mps = velocity_at(flight, tick),
          .acceleration_mps2 = flight.acceleration_mps2};
}

Quat World::orientation_at(std::uint32_t body, Tick tick) {
  const FreeFlight& flight = segments_[body].flight;
  if (constants_[body].is_sphere)
    return math::normalized(orientation_of(segments_[body], constants_[body].inertia, tick));
  if (turning_[body].placed_at == tick) return turning_[body].orientation;
  const bool turns = !is_zero(flight.angular_velocity_radps) ||
                     !is_zero(segments_[body].angular_acceleration_radps2);
  if (!turns) return flight.orientation;
  if (in_contact(segments_[body]))
    return math::normalized(orientation_of(segments_[body], constants_[body].inertia, tick));
  return math::normalized(turning_[body].track.orientation_at(tick));
}

Pose World::pose_at(std::uint32_t body, Tick tick) {
  return {.position_m = position_at(segments_[body].flight, tick),
          .orientation = orientation_at(body, tick)};
}

Twist World::twist_at(std::uint32_t body, Tick tick) {
  const FreeFlight& flight = segments_[body].flight;
  if (in_contact(segments_[body])) {
    const Vec3& half_way = supports_[body].half_way;
    if (is_zero(half_way)) return twist_of(segments_[body], constants_[body].inertia, tick);
    return twist_over_edge(round_body(body), segments_[body], half_way, scene_.gravity_mps2, tick);
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

double World::kinetic_energy_j(Tick tick) {
  double sum_j = 0;
  for (std::uint32_t body = 0; body < size(); ++body) {
    if (!started(body)) continue;
    sum_j += physics::kinetic_energy_j(constants_[body].inertia, orientation_at(body, tick),
                                       twist_at(body, tick));
  }
  return sum_j;
}

const MovingPiece& World::moving_at(std::uint32_t body, Tick tick) {
  Turning& turning = turning_[body];
  if (turning.placed_at == tick) return turning.placed;
  const Twist twist = twist_at(body, tick);
  const bool sphere = constants_[body].is_sphere;
  if (!sphere) turning.orientation = orientation_at(body, tick);
  const Vec3 place_m = position_at(segments_[body].flight, tick);
  turning.placed = {
      .radius_m = sphere ? constants_[body].reach_m : 0,
      .pose = sphere ? PlacedPose{.position_m = place_m}
                     : placed({.position_m = place_m, .orientation = turning.orientation}),
      .coordinates_m = coordinates_m_max(segments_[body].flight, tick),
      .velocity_mps = twist.velocity_mps,
      .acceleration_mps2 = segments_[body].flight.acceleration_mps2,
      .angular_velocity_radps = twist.angular_velocity_radps,
      .turning_acceleration_mps2 =
          sphere ? 0 : turning_acceleration_mps2_max(turning.bounds, constants_[body].reach_m),
      .turns_evenly = constants_[body].inertia.symmetry == InertiaSymmetry::spherical &&
                      is_zero(segments_[body].angular_acceleration_radps2),
      .reach_m = sphere ? 0 : constants_[body].reach_m};
  turning.placed_at = tick;
  return turning.placed;
}

MovingPiece World::part_at(std::uint32_t body, std::uint32_t part, Tick tick) {
  MovingPiece piece = moving_at(body, tick);
  piece.view = &parts_[constants_[body].first_part + part];
  if (constants_[body].is_sphere) piece.angular_velocity_radps = Vec3::Zero();
  return piece;
}

void World::forget_searches(bool use_places) {
  searches_.clear();
  // Only what may rest is slow enough for long enough; positions mustn't wrap.
  const bool useful = use_places && !only_spheres_ && resting_.enabled() && !periodic_;
  places_.reset(useful ? size() : 0, ticks_after(0.5 * scene_.slow.rest_time_s));
  for (std::uint32_t body = 0; useful && body < size(); ++body) {
    if (started(body) && is_resting(body)) note_place(body);
  }
}

void World::note_place(std::uint32_t body) {
  const Segment& segment = segments_[body];
  const double reach_m = constants_[body].reach_m;
  const bool round = constants_[body].is_sphere;
  const double turning_mps = round ? 0 : turning_speed_mps_max(turning_[body].bounds, reach_m);
  places_.began(
      body, reach_m,
      {.begin = segment.flight.begin,
       .pose = {segment.flight.position_m, round ? Quat::Identity() : segment.flight.orientation},
       .speed_mps = math::norm(segment.flight.velocity_mps) + turning_mps,
       .acceleration_mps2 = math::norm(segment.flight.acceleration_mps2),
       .stays = segment.mode == MotionMode::resting});
}

// ---- static geometry ----------------------------------------------------------------------------

std::uint32_t World::static_count(std::uint32_t body) const {
  if (constants_[body].is_sphere) return statics_.feature_count();
  return statics_.piece_count() + static_cast<std::uint32_t>(surfaces_.size());
}

void World::statics_near(std::uint32_t body, const Box& box,
                         std::vector<std::uint32_t>& found) const {
  if (constants_[body].is_sphere) {
    statics_.features_near(box, constants_[body].reach_m, found);
  } else {
    statics_.pieces_near(box, found);
    for (std::uint32_t i = statics_.piece_count(); i < static_count(body); ++i)
      if (surface_reaches(surface(i).surface, box)) found.push_back(i);
  }
}

void World::statics_in(std::uint32_t body, const Box& box, std::span<const std::uint32_t> some,
                       std::vector<std::uint32_t>& found) const {
  if (constants_[body].is_sphere) {
    const CentreRange centre(box, constants_[body].reach_m);
    std::ranges::copy_if(some, std::back_inserter(found),
                         [&](std::uint32_t index) { return statics_.may_meet(index, centre); });
  } else {
    std::ranges::copy_if(some, std::back_inserter(found), [&](std::uint32_t index) {
      return index < statics_.piece_count() ? statics_.piece_overlaps(index, box)
                                            : surface_reaches(surface(index).surface, box);
    });
  }
}

const std::string& World::static_name(std::uint32_t body, std::uint32_t index) const {
  if (constants_[body].is_sphere) return statics_.name_of_feature(index);
  return is_surface(body, index) ? surface(index).name : statics_.name_of_piece(index);
}

// ---- room and time ------------------------------------------------------------------------------

bool World::touching(std::uint32_t a, std::uint32_t b, Tick tick) {
  if (constants_[a].is_sphere && constants_[b].is_sphere) {
    return touches(
        gap_of_spheres_m(between_at(a, b, tick), constants_[a].reach_m + constants_[b].reach_m));
  }
  for (std::uint32_t i = 0; i < constants_[a].part_count; ++i) {
    for (std::uint32_t j = 0; j < constants_[b].part_count; ++j) {
      const MovingPiece first = part_at(a, i, tick);
      const MovingPiece second = part_at(b, j, tick);
      if (touches(contact_of(first, second).gap_m)) return true;
    }
  }
  return false;
}

bool World::touching_static(std::uint32_t body, std::uint32_t index, Tick tick) {
  if (constants_[body].is_sphere) {
    const SphereFeature& feature = statics_.feature(index);
    const MovingPoint centre = centre_at(body, tick);
    return touches(gap_between(feature, centre, constants_[body].reach_m).gap_m) &&
           is_inside(statics_.sides(feature), centre.position_m);
  }
  for (std::uint32_t part = 0; part < constants_[body].part_count; ++part) {
    if (touches(contact_with_static(index, body, part, tick).gap_m)) return true;
  }
  return false;
}

std::string World::solid_at(const Vec3& place_m) const {
  const std::string* solid = statics_.solid_at(place_m);
  if (solid != nullptr) return *solid;
  for (MetSurface& met : surfaces_) {
    if (place_m.z() < met.surface.at(place_m.x(), place_m.y()).height_m) return met.name;
  }
  return "";
}

TickCount World::span_of_travel(std::uint32_t body, Tick tick, double radii) const {
  const Path flight = path(body);
  const double way_m = radii * reach_m(body);
  // Sums of components in place of norms: this sets speed only.
  const Vec3& pull = flight.acceleration_mps2;
  const Vec3 velocity_mps = flight.velocity_mps + seconds(tick - flight.begin) * pull;
  const double speed_mps =
      (std::fabs(velocity_mps.x()) + std::fabs(velocity_mps.y())) + std::fabs(velocity_mps.z());
  const double a = (std::fabs(pull.x()) + std::fabs(pull.y())) + std::fabs(pull.z());
  const double rate =
      a == 0 ? 2 * speed_mps : speed_mps + std::sqrt(speed_mps * speed_mps + 2 * a * way_m);
  return rate > 0 ? ticks_after(2 * way_m / rate) : k_tick_max.value;
}

TickCount World::limited_span(std::uint32_t body, Tick tick, TickCount span,
                              double pad_radii) const {
  TickCount limited = std::min(span, k_tick_max - tick);
  if (!periodic_) return limited;
  const Flight& flight = flights_[body];
  for (int i = 0; i < 3; ++i) {
    const double period = scene_.period_m[static_cast<std::size_t>(i)];
    const double speed_mps = std::fabs(flight.velocity_mps[i]);
    if (period == 0 || speed_mps == 0) continue;
    // Of half a period each of the two has a half, less a hundredth of the period for roundings.
    const double way_m = 0.24 * period - (1 + 2 * pad_radii) * reach_m(body);
    limited = std::min(limited, ticks_before(way_m / speed_mps));
  }
  return std::max<TickCount>(1, limited);
}

double World::typical_box_m() const {
  double sum_m = 0;
  for (const BodyConstants& body : constants_)
    sum_m += 2 * body.reach_m;
  return constants_.empty() ? 1 : 1.3 * sum_m / static_cast<double>(constants_.size());
}

}  // namespace sleight::physics
