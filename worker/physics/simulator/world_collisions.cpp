// What collisions and controls do to bodies.
#include "worker/physics/contact/contact_events.h"
#include "worker/physics/simulator/world.h"
#include "worker/physics/simulator/world_at_event.h"

namespace sleight::physics {

SurfaceLaw World::law_of_static(std::uint32_t body, std::uint32_t index,
                                const Vec3& point_m) const {
  if (is_surface(body, index)) {
    const SurfaceControl law = surface(index).surface.fields_at(point_m.x(), point_m.y());
    return {.restitution = law.restitution, .friction = law.friction};
  }
  const MaterialId material = constants_[body].is_sphere ? statics_.material_of_feature(index)
                                                         : statics_.material_of_piece(index);
  SurfaceLaw law = scene_.contacts.between(constants_[body].material, material);
  law.friction = statics_.friction_at(index, point_m, law.friction);
  return law;
}

void World::note_too_much(std::uint32_t body, Tick tick) {
  note_failure(SceneError::Kind::too_many_collisions,
               words_of_too_much(collided_[body], scene_.slow.separation_speed_mps > 0), body,
               tick);
}

RigidImpactBody World::rigid_body(std::uint32_t body, Tick tick) {
  return {.mass = constants_[body].rigid_mass,
          .pose = pose_at(body, tick),
          .twist = twist_at(body, tick)};
}

PieceContact World::contact_at(std::uint32_t a, std::uint32_t b, const EventKey& event) {
  if (constants_[a].is_sphere && constants_[b].is_sphere) {
    return contact_of_spheres(position_at(segments_[a].flight, event.tick),
                              between_at(a, b, event.tick), constants_[a].reach_m,
                              constants_[b].reach_m);
  }
  if (const PieceContact* found = found_contact(a, b, event)) return *found;
  const std::uint32_t of_b = constants_[b].part_count;
  return contact_of(part_at(a, event.feature / of_b, event.tick),
                    part_at(b, event.feature % of_b, event.tick));
}

PieceContact World::static_contact_at(std::uint32_t body, std::uint32_t index,
                                      const EventKey& event) {
  if (constants_[body].is_sphere) {
    const Vec3 place_m = position_at(segments_[body].flight, event.tick);
    PieceContact contact;
    contact.gap_m =
        gap_between(statics_.feature(index), centre_at(body, event.tick), constants_[body].reach_m)
            .gap_m;
    contact.normal = normal_at(statics_.feature(index), place_m);
    contact.point_m = place_m - constants_[body].reach_m * contact.normal;
    return contact;
  }
  if (const PieceContact* found = found_contact(body, k_static | index, event)) return *found;
  return contact_with_static(index, body, event.feature, event.tick);
}

PieceContact World::contact_with_static(std::uint32_t index, std::uint32_t body, std::uint32_t part,
                                        Tick tick) {
  const MovingPiece piece = part_at(body, part, tick);
  if (is_surface(body, index))
    return contact_of(surface(index).surface, lattice_on(index, body, part), piece);
  return index < statics_.plane_count() ? contact_of(statics_.plane(index), piece)
                                        : contact_of(statics_.piece(index), piece);
}

void World::collide(std::uint32_t a, std::uint32_t b, const EventKey& event) {
  changed_.clear();
  if (replayed_count_ != 0) {
    make_live(a);
    make_live(b);
  }
  if (plain_spheres_ && free_spheres(a, b) && turns_[a] == 0 && turns_[b] == 0) {
    collide_plain(a, b, event);
    return;
  }
  static_assert(contact::Bodies<AtEvent>);
  AtEvent at(*this, event);
  const bool resolved =
      contact::collide(at, a, b, contact_at(a, b, event),
                       scene_.contacts.between(constants_[a].material, constants_[b].material));
  if (!resolved)
    note_failure(SceneError::Kind::impact_unresolved, "its impact can't be resolved", a,
                 event.tick);
}

void World::collide_static(std::uint32_t body, std::uint32_t index, const EventKey& event) {
  const PieceContact contact = static_contact_at(body, index, event);
  const bool plastic = count_at(body, event.tick) > k_elastic_at_a_tick;
  const SurfaceLaw law = law_of_static(body, index, contact.point_m);
  const bool surface = is_surface(body, index);
  if (surface) {
    const Vec3 place_m = position_at(segments_[body].flight, event.tick);
    note_surface(body, index, event.tick, place_m, contact.point_m - place_m);
  }
  AtEvent at(*this, event);
  contact::collide_static(
      at, body, index, contact,
      contact::law_of_impact(law.restitution, law.friction, scene_.slow, plastic),
      resting_.enabled() || surface);
}

void World::note_surface(std::uint32_t body, std::uint32_t index, Tick tick, const Vec3& centre_m,
                         const Vec3& arm_m) {
  surface_touches_.push_back({.tick = tick,
                              .body = body,
                              .surface = index - statics_.piece_count(),
                              .point_m = centre_m + arm_m});
}

void World::apply(const Control& control, const EventKey& event) {
  changed_.clear();
  const std::uint32_t body = control.body.value;
  make_live(body);
  Twist twist = twist_at(body, event.tick);
  twist.velocity_mps += control.velocity_change_mps;
  twist.angular_velocity_radps += control.angular_velocity_change_radps;
  AtEvent at(*this, event);
  contact::wake_dependents(at, body);
  note_contact_state(body);
  resting_.disturbed(body);
  at.begin_after(body, twist);
  contact::wake_on_those_that_left(at);
}

}  // namespace sleight::physics
