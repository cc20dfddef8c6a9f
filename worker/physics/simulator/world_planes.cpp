// Bodies that are no spheres and stay on planes and on faces of static polyhedra.
#include <algorithm>
#include <array>
#include <optional>

#include "worker/physics/collision/piece_corners.h"
#include "worker/physics/contact/plane_stay.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {
namespace {

/// A body that stays on what is flat is no deeper than this in it.
constexpr double k_sunk_m = 5e-7;

}  // namespace

Flat World::flat_of(std::uint32_t index, std::uint32_t face) const {
  if (index < statics_.plane_count()) {
    const HalfSpace& plane = statics_.plane(index);
    return {.normal = plane.normal,
            .offset_m = plane.offset_m,
            .sides = {},
            .map = statics_.friction_map(index)};
  }
  const ConvexView& view = *statics_.piece(index).view;
  const Face& one = view.faces[face];
  return {.normal = one.normal,
          .offset_m = one.offset_m,
          .sides = std::span(view.sides + one.first_side, one.side_count)};
}

std::optional<std::uint32_t> World::face_met(std::uint32_t index, const Vec3& normal) const {
  if (index < statics_.plane_count()) return 0;
  constexpr double k_same_cosine = 1 - 1e-9;
  const ConvexView& view = *statics_.piece(index).view;
  for (std::uint32_t face = 0; face < view.face_count; ++face) {
    if (math::dot(view.faces[face].normal, normal) > k_same_cosine) return face;
  }
  return std::nullopt;
}

World::PlaneSupports World::supports_on(std::uint32_t body, std::uint32_t index, const Flat& flat,
                                        Tick tick) {
  const double near_m = near_plane_m(scene_.slow, scene_.gravity_mps2);
  const Vec3 centre_m = position_at(segments_[body].flight, tick);
  const auto for_each_near = [&](const auto& visit) {
    for (std::uint32_t part = 0; part < constants_[body].part_count; ++part) {
      for_each_corner(part_at(body, part, tick), -flat.normal, near_m, [&](const Vec3& corner_m) {
        const double height_m = math::dot(flat.normal, corner_m) - flat.offset_m;
        if (height_m <= near_m && is_over(flat, corner_m)) visit(corner_m, height_m);
      });
    }
  };
  std::size_t near = 0;
  for_each_near([&](const Vec3& /*corner_m*/, double /*height_m*/) { ++near; });
  PlaneSupports supports;
  // Of too many, as of a prism of a hundred sides, some all around.
  const std::size_t every = near / supports.all.size() + 1;
  std::size_t nth = 0;
  for_each_near([&](const Vec3& corner_m, double height_m) {
    supports.lowest_m = std::min(supports.lowest_m, height_m);
    if (nth++ % every != 0) return;
    supports.all[supports.count++] = {.arm_m = corner_m - centre_m,
                                      .friction = law_of_static(body, index, corner_m).friction};
  });
  return supports;
}

std::optional<PlaneStay> World::stay_of(std::uint32_t body, std::uint32_t index, std::uint32_t face,
                                        const Twist& twist, Tick tick) {
  const Flat flat = flat_of(index, face);
  const PlaneSupports supports = supports_on(body, index, flat, tick);
  // What has sunk, as cones do by rounding, is let go and caught again where it touches.
  if (supports.count < 2 || supports.lowest_m < -k_sunk_m) return std::nullopt;
  const BodyConstants& constants = constants_[body];
  const Segment now = segment_after(body, tick, position_at(segments_[body].flight, tick), twist);
  const SurfaceLaw& law =
      scene_.contacts.between(constants.material, statics_.material_of_piece(index));
  const Quat& orientation = now.flight.orientation;
  std::optional<PlaneStay> stay = stay_on_plane(
      {.mass_kg = constants.inertia.mass_kg,
       .inertia_kgm2 = inertia_in_world(constants.inertia.principal_kgm2, orientation),
       .normal = flat.normal,
       .supports = std::span(supports.all).first(supports.count),
       .axis =
           is_zero(constants.axis) ? constants.axis : math::rotated(orientation, constants.axis),
       .rolling_friction = law.rolling_friction,
       .stick_mps = std::max(k_stick_mps, k_stick_bounces * scene_.slow.separation_speed_mps)},
      now.flight, flat, scene_.slow, scene_.gravity_mps2);
  if (stay) stay->face = face;
  return stay;
}

void World::note_plane_supports(std::uint32_t body, Tick tick) {
  const std::uint32_t index = supports_[body].features[0];
  const std::uint32_t face = supports_[body].features[1];
  const Flat flat = flat_of(index, face);
  const PlaneSupports supports = supports_on(body, index, flat, tick);
  for (const PlaneSupport& support : std::span(supports.all).first(supports.count))
    resting_.still_touches(body, {.tick = tick,
                                  .partner = k_static_partner,
                                  .feature = index,
                                  .friction = support.friction,
                                  .normal = flat.normal,
                                  .arm_m = support.arm_m});
}

}  // namespace sleight::physics
