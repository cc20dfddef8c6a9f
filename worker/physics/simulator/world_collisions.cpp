// What collisions, rest and controls do to bodies.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "worker/physics/simulator/world.h"

namespace sleight::physics {
namespace {

/// How fast the two sides of a contact part.
double parting_mps(const PieceContact& contact, const Twist& a, const Vec3& centre_a_m,
                   const Twist& b, const Vec3& centre_b_m) {
  const Vec3 of_a =
      a.velocity_mps + math::cross(a.angular_velocity_radps, contact.point_m - centre_a_m);
  const Vec3 of_b =
      b.velocity_mps + math::cross(b.angular_velocity_radps, contact.point_m - centre_b_m);
  return math::dot(contact.normal, of_b - of_a);
}

}  // namespace

ContactLaw World::contact_law(double restitution, double friction, bool plastic) const {
  if (plastic) return {.restitution = 0, .friction = friction};
  return {.restitution = restitution,
          .friction = friction,
          .separation_speed_floor_mps = scene_.slow.separation_speed_mps};
}

ContactLaw World::law_of(MaterialId a, MaterialId b, bool plastic) const {
  const SurfaceLaw& law = scene_.contacts.between(a, b);
  return contact_law(law.restitution, law.friction, plastic);
}

ContactLaw World::law_of_static(std::uint32_t body, std::uint32_t index, const Vec3& point_m,
                                bool plastic) const {
  if (is_surface(body, index)) {
    const SurfaceControl law = surface(index).surface.fields_at(point_m.x(), point_m.y());
    return contact_law(law.restitution, law.friction, plastic);
  }
  const MaterialId material = constants_[body].is_sphere ? statics_.material_of_feature(index)
                                                         : statics_.material_of_piece(index);
  return law_of(constants_[body].material, material, plastic);
}

std::uint32_t World::count_at(std::uint32_t body, Tick tick) {
  AtTick& at = at_tick_[body];
  at.events = at.tick == tick ? at.events + 1 : 1;
  at.tick = tick;
  if (at.events > k_events_at_a_tick_max) {
    note_failure(SceneError::Kind::too_many_collisions,
                 fmt::format("it collides more than {} times at one tick", k_events_at_a_tick_max),
                 body, tick);
  }
  if (tick - at.window > k_window) {
    at.window = tick;
    at.in_window = 0;
  }
  if (++at.in_window > k_collisions_in_window_max) {
    note_failure(SceneError::Kind::too_many_collisions,
                 fmt::format("it collides more than {} times in a millisecond; {}",
                             k_collisions_in_window_max,
                             scene_.slow.separation_speed_mps > 0
                                 ? "a much heavier body squeezes it, or it is wedged"
                                 : "let slow contacts end (SlowContacts)"),
                 body, tick);
  }
  return at.events;
}

RigidImpactBody World::rigid_body(std::uint32_t body, Tick tick) {
  return {.mass = constants_[body].rigid_mass,
          .pose = pose_at(body, tick),
          .twist = twist_at(body, tick)};
}

double World::fastest_point_mps(std::uint32_t body, const Twist& twist) const {
  const double turning = constants_[body].reach_m * math::norm(twist.angular_velocity_radps);
  return math::norm(twist.velocity_mps) + turning;
}

PieceContact World::contact_at(std::uint32_t a, std::uint32_t b, const EventKey& event) {
  if (constants_[a].is_sphere && constants_[b].is_sphere) {
    const Vec3 place_a_m = position_at(segments_[a].flight, event.tick);
    const Vec3 between_m = between_at(a, b, event.tick);
    PieceContact contact;
    const double distance_m = math::norm(between_m);
    contact.gap_m = distance_m - (constants_[a].reach_m + constants_[b].reach_m);
    contact.normal = between_m / distance_m;
    contact.point_m = place_a_m + constants_[a].reach_m * contact.normal;
    return contact;
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
        gap_to(statics_.feature(index), centre_at(body, event.tick), constants_[body].reach_m)
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

/// The impact of two bodies, either of which may take it as static geometry does.
ImpactOutput World::impact_of(std::uint32_t a, std::uint32_t b, const PieceContact& contact,
                              const ContactLaw& law, Tick tick, bool a_fixed, bool b_fixed) {
  if (constants_[a].is_sphere && constants_[b].is_sphere) {
    return sphere_impact({.mass_a = a_fixed ? SphereMass{} : constants_[a].sphere_mass,
                          .mass_b = b_fixed ? SphereMass{} : constants_[b].sphere_mass,
                          .a = twist_at(a, tick),
                          .b = twist_at(b, tick),
                          .normal = contact.normal,
                          .law = law});
  }
  return rigid_impact({.a = a_fixed ? RigidImpactBody{} : rigid_body(a, tick),
                       .b = b_fixed ? RigidImpactBody{} : rigid_body(b, tick),
                       .contact_m = contact.point_m,
                       .normal = contact.normal,
                       .law = law});
}

/// A body flies on from an event with another twist.
void World::begin_after(std::uint32_t body, const Twist& twist, const EventKey& event) {
  const Vec3 place_m = position_at(segments_[body].flight, event.tick);
  begin_segment(body, segment_after(body, event.tick, place_m, twist), event);
  changed_.push_back(body);
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
  const Tick tick = event.tick;
  const PieceContact contact = contact_at(a, b, event);
  const bool plastic = std::max(count_at(a, tick), count_at(b, tick)) > k_elastic_at_a_tick;
  const ContactLaw law = law_of(constants_[a].material, constants_[b].material, plastic);
  recent_.note(a, b, tick, contact.gap_m);
  if (history_builder_) history_builder_->meet(contact.gap_m);
  if (!supports_.empty()) {
    supports_[a].met_body = tick;
    supports_[b].met_body = tick;
  }
  bool a_rests = is_resting(a);
  bool b_rests = is_resting(b);
  ImpactOutput after = impact_of(a, b, contact, law, tick, a_rests, b_rests);
  if (a_rests || b_rests) {
    // A blow that is hard enough wakes the resting one, which then takes part.
    const std::uint32_t sleeper = a_rests ? a : b;
    const double jump_mps = math::norm(after.impulse_ns) / constants_[sleeper].inertia.mass_kg;
    if (jump_mps > resting_.wake_speed_mps()) {
      a_rests = false;
      b_rests = false;
      after = impact_of(a, b, contact, law, tick, false, false);
      wake_dependents(sleeper, event);
    }
  }
  // What rolls along a resting body has no slip to pay its bounces from.
  if (a_rests != b_rests) {
    const std::uint32_t mover = a_rests ? b : a;
    Twist& twist = a_rests ? after.b : after.a;
    if (constants_[mover].is_sphere) {
      const Vec3 normal = a_rests ? contact.normal : Vec3(-contact.normal);
      twist = hop(round_body(mover), normal, twist, hop_speed_mps());
    }
  }
  if (after.regime == ImpactRegime::unresolved)
    note_failure(SceneError::Kind::impact_unresolved, "its impact can't be resolved", a, tick);
  if (resting_.enabled()) {
    const Vec3 place_a_m = position_at(segments_[a].flight, tick);
    const Vec3 place_b_m = position_at(segments_[b].flight, tick);
    const double parting = parting_mps(contact, after.a, place_a_m, after.b, place_b_m);
    if (!a_rests) {
      note_touch(a,
                 {.tick = tick,
                  .partner = b,
                  .friction = law.friction,
                  .normal = -contact.normal,
                  .arm_m = contact.point_m - place_a_m},
                 resting_.is_slow(fastest_point_mps(a, twist_at(a, tick)),
                                  fastest_point_mps(a, after.a), parting));
    }
    if (!b_rests) {
      note_touch(b,
                 {.tick = tick,
                  .partner = a,
                  .friction = law.friction,
                  .normal = contact.normal,
                  .arm_m = contact.point_m - place_b_m},
                 resting_.is_slow(fastest_point_mps(b, twist_at(b, tick)),
                                  fastest_point_mps(b, after.b), parting));
    }
  }
  if (!a_rests) begin_after(a, after.a, event);
  if (!b_rests) begin_after(b, after.b, event);
  wake_on_those_that_left(event);
}

void World::collide_static(std::uint32_t body, std::uint32_t index, const EventKey& event) {
  changed_.clear();
  const Tick tick = event.tick;
  const PieceContact contact = static_contact_at(body, index, event);
  ContactLaw law =
      law_of_static(body, index, contact.point_m, count_at(body, tick) > k_elastic_at_a_tick);
  const Twist before = twist_at(body, tick);
  const auto log_touch = [&](const Twist& after) {
    if (!resting_.enabled() && !is_surface(body, index)) return;
    const Vec3 place_m = position_at(segments_[body].flight, tick);
    if (is_surface(body, index))
      note_surface(body, index, tick, place_m, contact.point_m - place_m);
    note_touch(body,
               {.tick = tick,
                .partner = k_static_partner,
                .feature = index,
                .friction = law.friction,
                .normal = contact.normal,
                .arm_m = contact.point_m - place_m},
               resting_.is_slow(fastest_point_mps(body, before), fastest_point_mps(body, after),
                                parting_mps(contact, {}, Vec3::Zero(), after, place_m)));
  };
  const double approach_mps = -math::dot(contact.normal, before.velocity_mps);
  const bool caught = is_caught(body, index, approach_mps, law.restitution, tick);
  if (caught) law = {.restitution = 0, .friction = law.friction};
  ImpactOutput after = constants_[body].is_sphere
                           ? sphere_impact({.mass_a = {},
                                            .mass_b = constants_[body].sphere_mass,
                                            .a = {},
                                            .b = before,
                                            .normal = contact.normal,
                                            .law = law})
                           : rigid_impact({.a = {},
                                           .b = rigid_body(body, tick),
                                           .contact_m = contact.point_m,
                                           .normal = contact.normal,
                                           .law = law});
  if (caught) {
    log_touch(after.b);
    begin_caught(body, index, after.b, event);
    wake_on_those_that_left(event);
    return;
  }
  if (constants_[body].is_sphere && scene_.slow.separation_speed_mps > 0)
    after.b = hop(round_body(body), contact.normal, after.b, hop_speed_mps());
  log_touch(after.b);
  begin_after(body, after.b, event);
  wake_on_those_that_left(event);
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
  wake_dependents(body, event);
  note_contact_state(body);
  resting_.disturbed(body);
  begin_after(body, twist, event);
  wake_on_those_that_left(event);
}

}  // namespace sleight::physics
