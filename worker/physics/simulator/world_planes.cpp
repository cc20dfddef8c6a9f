// Lasting contact with planes and with faces of static polyhedra, for bodies that aren't spheres.
#include <algorithm>
#include <array>
#include <optional>

#include "worker/physics/collision/piece_corners.h"
#include "worker/physics/contact/plane_stay.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {
World::PlaneSupports World::supports_on(BodyId body, StaticId met, const Flat& flat, Tick tick) {
  const double near_m = near_plane_m(scene().slow, scene().gravity_mps2);
  const Vec3 centre_m = bodies_.position_at(body, tick);
  const auto for_each_near = [&](const auto& visit) {
    for (std::uint32_t part = 0; part < bodies_.constants(body).part_count; ++part) {
      for_each_corner(bodies_.part_at(body, part, tick), -flat.normal, near_m,
                      [&](const Vec3& corner_m) {
                        const double height_m = math::dot(flat.normal, corner_m) - flat.offset_m;
                        if (height_m <= near_m && is_over(flat, corner_m))
                          visit(corner_m, height_m);
                      });
    }
  };
  std::size_t near = 0;
  for_each_near([&](const Vec3& /*corner_m*/, double /*height_m*/) { ++near; });
  PlaneSupports supports;
  // If there are too many supports, as on a prism with a hundred sides, select some that are spread
  // all around.
  const std::size_t every = near / supports.all.size() + 1;
  std::size_t nth = 0;
  for_each_near([&](const Vec3& corner_m, double height_m) {
    supports.lowest_m = std::min(supports.lowest_m, height_m);
    if (nth++ % every != 0) return;
    supports.all[supports.count++] = {.arm_m = corner_m - centre_m,
                                      .friction = statics_.law(body, met, corner_m).friction};
  });
  return supports;
}

std::optional<PlaneStay> World::stay_of(BodyId body, StaticId met, std::uint32_t face,
                                        const Twist& twist, Tick tick) {
  const Flat flat = flat_at(statics_.geometry(), met, face);
  const PlaneSupports supports = supports_on(body, met, flat, tick);
  // If a body has sunk, release it; when it touches again, it is caught again. Cones sink by
  // rounding.
  if (supports.count < 2 || supports.lowest_m < -k_sunk_m) return std::nullopt;
  const BodyConstants& constants = bodies_.constants(body);
  const Segment now = bodies_.segment_after(body, tick, bodies_.position_at(body, tick), twist);
  const SurfaceLaw& law =
      scene().contacts.between(constants.material, statics_.geometry().material_of_piece({met}));
  const Quat& orientation = now.flight.orientation;
  std::optional<PlaneStay> stay = stay_on_plane(
      {.mass_kg = constants.inertia.mass_kg,
       .inertia_kgm2 = inertia_in_world(constants.inertia.principal_kgm2, orientation),
       .normal = flat.normal,
       .supports = std::span(supports.all).first(supports.count),
       .axis =
           is_zero(constants.axis) ? constants.axis : math::rotated(orientation, constants.axis),
       .rolling_friction = law.rolling_friction,
       .stick_mps = std::max(k_stick_mps, k_stick_bounces * scene().slow.separation_speed_mps)},
      now.flight, flat, scene().slow, scene().gravity_mps2);
  if (stay) stay->face = face;
  return stay;
}

void World::note_plane_supports(BodyId body, Tick tick) {
  const StaticId met = bodies_.supports_of(body).features[0];
  const std::uint32_t face = bodies_.supports_of(body).face;
  const Flat flat = flat_at(statics_.geometry(), met, face);
  const PlaneSupports supports = supports_on(body, met, flat, tick);
  for (const PlaneSupport& support : std::span(supports.all).first(supports.count))
    resting_.still_touches(body, {.tick = tick,
                                  .partner = k_static_partner,
                                  .feature = met,
                                  .friction = support.friction,
                                  .normal = flat.normal,
                                  .arm_m = support.arm_m});
}

}  // namespace sleight::physics
