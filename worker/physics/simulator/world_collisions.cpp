// What collisions and controls do to bodies.
#include "worker/physics/simulator/world.h"

namespace sleight::physics {

ContactLaw World::law_of(MaterialId a, MaterialId b) const {
  const SurfaceLaw& law = scene_.contacts.between(a, b);
  return {.restitution = law.restitution,
          .friction = law.friction,
          .separation_speed_floor_mps = scene_.slow.separation_speed_mps};
}

RigidImpactBody World::rigid_body(std::uint32_t body, Tick tick) {
  return {.mass = constants_[body].rigid_mass,
          .pose = pose_at(body, tick),
          .twist = twist_at(body, tick)};
}

void World::collide(std::uint32_t a, std::uint32_t b, const Image& image, const EventKey& event) {
  const Tick tick = event.tick;
  const Vec3 place_a_m = position_at(segments_[a].flight, tick);
  const Vec3 place_b_m = position_at(segments_[b].flight, tick);
  const ContactLaw law = law_of(constants_[a].material, constants_[b].material);
  ImpactOutput after;
  if (constants_[a].is_sphere && constants_[b].is_sphere) {
    const Vec3 between_m = shifted(place_b_m, image, scene_.period_m) - place_a_m;
    after = sphere_impact({.mass_a = constants_[a].sphere_mass,
                           .mass_b = constants_[b].sphere_mass,
                           .a = twist_at(a, tick),
                           .b = twist_at(b, tick),
                           .normal = math::normalized(between_m),
                           .law = law});
  } else {
    const std::uint32_t of_b = constants_[b].part_count;
    const PieceContact contact =
        contact_of(part_at(a, event.feature / of_b, tick), part_at(b, event.feature % of_b, tick));
    after = rigid_impact({.a = rigid_body(a, tick),
                          .b = rigid_body(b, tick),
                          .contact_m = contact.point_m,
                          .normal = contact.normal,
                          .law = law});
  }
  const Segment next_a = segment_after(a, tick, place_a_m, after.a);
  const Segment next_b = segment_after(b, tick, place_b_m, after.b);
  begin_segment(a, next_a, event);
  begin_segment(b, next_b, event);
}

void World::collide_static(std::uint32_t body, std::uint32_t index, const EventKey& event) {
  const Tick tick = event.tick;
  const Vec3 place_m = position_at(segments_[body].flight, tick);
  ImpactOutput after;
  if (constants_[body].is_sphere) {
    after = sphere_impact(
        {.mass_a = {},
         .mass_b = constants_[body].sphere_mass,
         .a = {},
         .b = twist_at(body, tick),
         .normal = normal_at(statics_.feature(index), place_m),
         .law = law_of(constants_[body].material, statics_.material_of_feature(index))});
  } else {
    const MovingPiece piece = part_at(body, event.feature, tick);
    const PieceContact contact = index < statics_.plane_count()
                                     ? contact_of(statics_.plane(index), piece)
                                     : contact_of(statics_.piece(index), piece);
    after =
        rigid_impact({.a = {},
                      .b = rigid_body(body, tick),
                      .contact_m = contact.point_m,
                      .normal = contact.normal,
                      .law = law_of(constants_[body].material, statics_.material_of_piece(index))});
  }
  begin_segment(body, segment_after(body, tick, place_m, after.b), event);
}

void World::apply(const Control& control, const EventKey& event) {
  const std::uint32_t body = control.body.value;
  Twist twist = twist_at(body, event.tick);
  twist.velocity_mps += control.velocity_change_mps;
  twist.angular_velocity_radps += control.angular_velocity_change_radps;
  const Vec3 place_m = position_at(segments_[body].flight, event.tick);
  begin_segment(body, segment_after(body, event.tick, place_m, twist), event);
}

}  // namespace sleight::physics
