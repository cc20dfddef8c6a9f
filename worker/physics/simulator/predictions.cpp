#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/physics/simulator/predictions.h"

namespace sleight::physics {
namespace {

/// Maximum number of ticks that a search tests in advance. After that, the search waits until its
/// next tick is due, because most pairs change their motion before then. Affects speed only.
constexpr int k_looks_ahead = 32;

/// In place of a feature's number: the search exceeded its limit.
constexpr std::uint32_t k_gave_up = UINT32_MAX;

/// Tests a few ticks of a search without stored state.
template <class Examine>
Prediction looked_ahead(Tick tick, Tick until, const Examine& examine) {
  for (int look = 0; look < k_looks_ahead; ++look) {
    const Examined examined = examine(tick);
    if (examined.collides) return {.tick = tick, .certain = true};
    if (examined.next == k_never) return {};
    tick = examined.next;
    if (tick > until) break;
  }
  return {.tick = tick, .certain = false};
}

/// Continues the searches of all pairs of parts up to `now`. examine(i, tick, search) tests the
/// i-th pair of parts. Returns the earliest collision; if several are tied, the one with the lowest
/// number.
template <class Examine>
Prediction advanced(std::span<PieceSearch> searches, Tick now, const Examine& examine) {
  Prediction first;
  for (std::uint32_t i = 0; i < searches.size(); ++i) {
    PieceSearch& search = searches[i];
    bool certain = false;
    while (search.next <= now && !certain) {
      if (++search.looks > k_examined_ticks_max) return {.tick = now, .feature = k_gave_up};
      const Examined examined = examine(i, search.next, search);
      certain = examined.collides;
      if (!certain) search.next = examined.next;
    }
    if (search.next < first.tick || (search.next == first.tick && first.certain && !certain)) {
      first = {.tick = search.next, .feature = i, .certain = certain};
    }
  }
  return first;
}

}  // namespace

Predictions::Predictions(Bodies& bodies, const MetStatics& statics, bool contacts_matter)
    : bodies_(bodies), statics_(statics) {
  recent_.reset(contacts_matter ? bodies.size() : 0);
  searches_.reserve(bodies.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double period_m = bodies.scene().period_m[axis];
    if (period_m == 0) continue;
    images_.period_m.set(axis, period_m);
    images_.half_m.set(axis, 0.5 * period_m);
    images_.middle_m.set(axis, 0.9 * period_m);
    images_.sure_m.set(axis, 0.35 * period_m);
  }
}

void Predictions::forget_searches(bool use_places) {
  searches_.clear();
  // Remembered places save work only if bodies are slow for long, as in scenes where they can rest.
  // Places also require that positions don't wrap around.
  const bool useful = use_places && !bodies_.only_spheres() &&
                      bodies_.scene().slow.rest_speed_mps > 0 && !bodies_.periodic();
  places_.reset(useful ? bodies_.size() : 0, ticks_after(0.5 * bodies_.scene().slow.rest_time_s));
  for (BodyId body{}; useful && body < bodies_.size(); ++body) {
    if (bodies_.started(body) && bodies_.is_resting(body)) note_place(body);
  }
}

void Predictions::note_place(BodyId body) {
  const Segment& segment = bodies_.segment(body);
  const double reach_m = bodies_.constants(body).reach_m;
  const bool round = bodies_.is_sphere(body);
  const double turning_mps = round ? 0 : bodies_.turning_speed_mps(body);
  // A fixed body's place needs no room.
  places_.began(
      body, bodies_.is_fixed(body) ? 0 : reach_m,
      {.begin = segment.flight.begin,
       .pose = {segment.flight.position_m, round ? Quat::Identity() : segment.flight.orientation},
       .speed_mps = math::norm(segment.flight.velocity_mps) + turning_mps,
       .acceleration_mps2 = math::norm(segment.flight.acceleration_mps2),
       .stays = segment.mode == MotionMode::resting});
}

// ---- two bodies ---------------------------------------------------------------------------------

Prediction Predictions::predict(BodyId a, BodyId b, Tick now, std::uint32_t& search) {
  const Tick begin = std::max(bodies_.flight(a).begin, bodies_.flight(b).begin);
  const bool both_free = bodies_.mode(a) == MotionMode::free && bodies_.mode(b) == MotionMode::free;
  if (bodies_.is_sphere(a) && bodies_.is_sphere(b)) {
    const bool closed = both_free && refractory_of_spheres(a, b).until <= begin;
    return closed ? predict_free_spheres(a, b, now) : predict_spheres(a, b, now);
  }
  if (bodies_.is_resting(a) && bodies_.is_resting(b)) return {};
  const std::size_t pairs =
      std::size_t{bodies_.constants(a).part_count} * std::size_t{bodies_.constants(b).part_count};
  // Skip the search if both bodies stay near places in which they can't touch each other.
  const PlacesOfPair places = places_.enabled() ? places_.of(a, b, now) : 0;
  if (places != 0 && search != k_no_search) {
    bool all_clear = true;
    for (const PieceSearch& part : searches_.of(search))
      all_clear = all_clear && part.clear_in == places;
    if (all_clear) {
      const Tick until = places_.until(a, b);
      for (PieceSearch& part : searches_.of(search)) {
        part.next = until;
        part.looks = 0;
      }
      return {.tick = until};
    }
  }
  // First stage: the bounding spheres.
  TickCount span = 0;
  if (both_free) {
    const MovingPoint first = bodies_.centre_at(a, begin);
    const MovingPoint second = bodies_.centre_at(b, begin);
    span = touch_of_free_spheres(second.position_m - first.position_m,
                                 second.velocity_mps - first.velocity_mps,
                                 bodies_.constants(a).reach_m + bodies_.constants(b).reach_m);
    if (span >= k_tick_max.value) return {};
  }
  // Second stage: the parts.
  for (PieceSearch& part : searches_.fresh(search, pairs))
    part.next = begin + span;
  return look(a, b, now, search);
}

Prediction Predictions::look(BodyId a, BodyId b, Tick now, std::uint32_t search) {
  if (bodies_.is_sphere(a) && bodies_.is_sphere(b)) return predict_spheres(a, b, now);
  const std::uint32_t of_b = bodies_.constants(b).part_count;
  // Compute the parts' refractory time only when it is needed: most tested ticks are after it.
  Refractory refractory = refractory_of(a, b);
  bool asked = false;
  const bool several = searches_.of(search).size() > 1;
  const double reach_a_m = bodies_.constants(a).reach_m;
  const double reach_b_m = bodies_.constants(b).reach_m;
  const Prediction prediction = advanced(
      searches_.of(search), now, [&](std::uint32_t i, Tick tick, PieceSearch& search_of_parts) {
        PieceContact contact;
        if (tick <= refractory.until && !asked) {
          refractory = refractory_of_parts(a, b);
          asked = true;
        }
        const Examined examined = examined_at(tick, refractory, [&](double touch_m) {
          Examined apart;
          if (spheres_apart(bodies_.centre_at(a, tick), bodies_.centre_at(b, tick),
                            reach_a_m + reach_b_m, std::min(reach_a_m, reach_b_m), tick, apart))
            return apart;
          if (several && hulls_apart(a, b, tick, touch_m, search_of_parts.cache, apart))
            return apart;
          return examine_pieces(bodies_.part_at(a, i / of_b, tick),
                                bodies_.part_at(b, i % of_b, tick), tick, touch_m,
                                search_of_parts.cache, contact);
        });
        if (examined.collides) {
          found_ = {tick, a, b, i, contact};
        } else if (places_.enabled()) {
          const PlacesOfPair places = places_.of(a, b, tick);
          if (places != 0 && examined.gap_m > places_.clear_m(a, b))
            search_of_parts.clear_in = places;
        }
        return examined;
      });
  if (prediction.feature == k_gave_up) gives_up(a, now);
  return prediction;
}

bool Predictions::hulls_apart(BodyId a, BodyId b, Tick tick, double touch_m, SeparationCache& cache,
                              Examined& examined) {
  HullLook& look = hull_look_;
  if (look.tick != tick || look.a != a || look.b != b || look.touch_m != touch_m) {
    look = {.tick = tick, .a = a, .b = b, .touch_m = touch_m, .apart = false, .examined = {}};
    const std::optional<MovingPiece> first = bodies_.hull_at(a, tick);
    const std::optional<MovingPiece> second = first ? bodies_.hull_at(b, tick) : std::nullopt;
    if (second && (is_round(*first) || is_round(*second))) {
      PieceContact contact;
      look.examined = examine_pieces(*first, *second, tick, touch_m, cache, contact);
      look.apart = !look.examined.collides && look.examined.gap_m > touch_m;
    }
  }
  examined = look.examined;
  return look.apart;
}

Refractory Predictions::refractory_of_parts(BodyId a, BodyId b) {
  const Refractory refractory = refractory_of(a, b);
  const Tick begin = std::max(bodies_.flight(a).begin, bodies_.flight(b).begin);
  if (refractory.until <= begin) return refractory;
  // For each pair of parts, compare the approach speed at the closest points. Usually no point is
  // fast.
  const MovingPiece& first = bodies_.moving_at(a, begin);
  const MovingPiece& second = bodies_.moving_at(b, begin);
  const double turning_mps =
      bodies_.constants(a).reach_m * math::norm(first.angular_velocity_radps) +
      bodies_.constants(b).reach_m * math::norm(second.angular_velocity_radps);
  if (math::norm(second.velocity_mps - first.velocity_mps) + turning_mps < k_fast_approach_mps)
    return refractory;
  for (std::uint32_t i = 0; i < bodies_.constants(a).part_count; ++i) {
    for (std::uint32_t j = 0; j < bodies_.constants(b).part_count; ++j) {
      const PieceContact contact =
          contact_of(bodies_.part_at(a, i, begin), bodies_.part_at(b, j, begin));
      if (touches(contact.gap_m) && contact.rate_mps < -k_fast_approach_mps) return {};
    }
  }
  return refractory;
}

Refractory Predictions::refractory_of_spheres(BodyId a, BodyId b) const {
  const Refractory refractory = refractory_of(a, b);
  const Tick begin = std::max(bodies_.flight(a).begin, bodies_.flight(b).begin);
  if (refractory.until <= begin) return refractory;
  // The speeds at `begin` suffice: free motion hardly changes them during the refractory time.
  const Vec3 between_m = bodies_.between_at(a, b, begin);
  const Vec3 relative_mps =
      velocity_at(bodies_.segment(b).flight, begin) - velocity_at(bodies_.segment(a).flight, begin);
  const bool fast =
      math::dot(between_m, relative_mps) < -k_fast_approach_mps * math::norm(between_m);
  return fast ? Refractory{} : refractory;
}

Prediction Predictions::predict_spheres(BodyId a, BodyId b, Tick from) const {
  if (bodies_.is_resting(a) && bodies_.is_resting(b)) return {};
  const double radii_m = bodies_.constants(a).reach_m + bodies_.constants(b).reach_m;
  const Refractory refractory = refractory_of_spheres(a, b);
  return looked_ahead(from, k_never, [&](Tick tick) {
    const MovingPoint p = bodies_.centre_at(a, tick);
    const MovingPoint q = bodies_.centre_at(b, tick);
    const MovingPoint relative{.position_m = bodies_.between_at(a, b, tick),
                               .velocity_mps = q.velocity_mps - p.velocity_mps,
                               .acceleration_mps2 = q.acceleration_mps2 - p.acceleration_mps2};
    const double coordinates_m = std::max(size_of(p.position_m), size_of(q.position_m));
    return examined_at(tick, refractory, [&](double touch_m) {
      return examine_spheres(relative, radii_m, coordinates_m, touch_m, tick);
    });
  });
}

bool Predictions::touching(BodyId a, BodyId b, Tick tick) {
  if (bodies_.is_sphere(a) && bodies_.is_sphere(b)) {
    return touches(gap_of_spheres_m(bodies_.between_at(a, b, tick),
                                    bodies_.constants(a).reach_m + bodies_.constants(b).reach_m));
  }
  for (std::uint32_t i = 0; i < bodies_.constants(a).part_count; ++i) {
    for (std::uint32_t j = 0; j < bodies_.constants(b).part_count; ++j) {
      const MovingPiece first = bodies_.part_at(a, i, tick);
      const MovingPiece second = bodies_.part_at(b, j, tick);
      if (touches(contact_of(first, second).gap_m)) return true;
    }
  }
  return false;
}

PieceContact Predictions::contact_at(BodyId a, BodyId b, const EventKey& event) {
  if (bodies_.is_sphere(a) && bodies_.is_sphere(b)) {
    return contact_of_spheres(bodies_.position_at(a, event.tick),
                              bodies_.between_at(a, b, event.tick), bodies_.constants(a).reach_m,
                              bodies_.constants(b).reach_m);
  }
  if (const PieceContact* found = found_contact(a, b, event)) return *found;
  const std::uint32_t of_b = bodies_.constants(b).part_count;
  return contact_of(bodies_.part_at(a, event.feature / of_b, event.tick),
                    bodies_.part_at(b, event.feature % of_b, event.tick));
}

// ---- images -------------------------------------------------------------------------------------

Prediction Predictions::predict_any_image(BodyId a, BodyId b, Tick now) const {
  // Until two bodies have moved by half a period relative to each other, the first can meet only
  // some images of the second: those within one period of the nearest image.
  const Vec3 between_m = bodies_.position_at(b, now) - bodies_.position_at(a, now);
  const Vec3 nearest_m = bodies_.to_nearest_image(between_m);
  const Vec3 relative_mps =
      velocity_at(bodies_.segment(b).flight, now) - velocity_at(bodies_.segment(a).flight, now);
  double half_m = std::numeric_limits<double>::infinity();
  for (const double period : bodies_.scene().period_m) {
    if (period > 0) half_m = std::min(half_m, 0.5 * period);
  }
  const double speed_mps = math::norm(relative_mps);
  Prediction first;
  if (speed_mps > 0) first.tick = now + std::max<TickCount>(1, ticks_before(half_m / speed_mps));
  const auto reach = [&](std::size_t axis) { return bodies_.scene().period_m[axis] > 0 ? 1 : 0; };
  for (int x = -reach(0); x <= reach(0); ++x) {
    for (int y = -reach(1); y <= reach(1); ++y) {
      for (int z = -reach(2); z <= reach(2); ++z) {
        const Vec3 shift_m =
            nearest_m + Vec3(x * bodies_.scene().period_m[0], y * bodies_.scene().period_m[1],
                             z * bodies_.scene().period_m[2]);
        const Prediction prediction = predict_free_spheres_at(a, b, shift_m);
        if (prediction.tick < now || prediction.tick > first.tick) continue;
        first = prediction;
      }
    }
  }
  return first;
}

// ---- a body and static geometry -----------------------------------------------------------------

Prediction Predictions::predict_static(BodyId body, StaticId met, Tick now, std::uint32_t& search,
                                       Tick until) {
  if (bodies_.is_resting(body)) return {};
  if (bodies_.is_sphere(body)) return look_static(body, met, now, search, until);
  if (bodies_.stays_on_faces(body) && bodies_.supports(body).holds(met)) return {};
  for (PieceSearch& part : searches_.fresh(search, bodies_.constants(body).part_count))
    part.next = bodies_.flight(body).begin;
  return look_static(body, met, now, search, until);
}

Prediction Predictions::look_static(BodyId body, StaticId met, Tick now, std::uint32_t search,
                                    Tick until) {
  if (!bodies_.is_sphere(body)) {
    const Prediction prediction = advanced(
        searches_.of(search), now, [&](std::uint32_t part, Tick tick, PieceSearch& search_of_part) {
          PieceContact contact;
          const auto examine_part = [&] {
            if (statics_.is_surface(body, met)) {
              MetSurface& surface = statics_.surface(met);
              NearPoints& near = surface.near[bodies_.constants(body).first_part + part];
              if (search_of_part.looks == 1) near.forget_motion();
              return examine_surface(surface.surface, statics_.lattice_on(met, body, part),
                                     bodies_.part_at(body, part, tick), tick, near, contact);
            }
            if (met >= statics_.geometry().plane_count()) {
              return examine_pieces(statics_.geometry().piece({met}),
                                    bodies_.part_at(body, part, tick), tick, k_touch_m,
                                    search_of_part.cache, contact);
            }
            Examined above;
            if (sphere_above(statics_.geometry().plane({met}), bodies_.centre_at(body, tick),
                             bodies_.constants(body).reach_m, tick, above))
              return above;
            return examine_plane(statics_.geometry().plane({met}),
                                 bodies_.part_at(body, part, tick), tick, k_touch_m, contact);
          };
          const Examined examined = examine_part();
          if (examined.collides) found_ = {tick, body, k_static | met, part, contact};
          return examined;
        });
    if (prediction.feature == k_gave_up) gives_up(body, now);
    return prediction;
  }
  // Before its mode event, a sphere can't meet its own supports.
  if (bodies_.stays_on_faces(body) && bodies_.supports(body).holds(met)) return {};
  const SphereFeature& feature = statics_.geometry().feature({met});
  const double radius_m = bodies_.constants(body).reach_m;
  if (until < k_tick_max &&
      keeps_clear(feature, statics_.geometry().sides(feature), bodies_.centre_at(body, now),
                  radius_m, seconds(until + 1 - now)))
    return {.tick = until + 1, .certain = false};
  return looked_ahead(now, until, [&](Tick tick) {
    return examine(feature, statics_.geometry().sides(feature), bodies_.centre_at(body, tick),
                   radius_m, tick);
  });
}

PieceContact Predictions::static_contact_at(BodyId body, StaticId met, const EventKey& event) {
  if (bodies_.is_sphere(body)) {
    const Vec3 place_m = bodies_.position_at(body, event.tick);
    PieceContact contact;
    contact.gap_m =
        gap_between(statics_.geometry().feature({met}), bodies_.centre_at(body, event.tick),
                    bodies_.constants(body).reach_m)
            .gap_m;
    contact.normal = normal_at(statics_.geometry().feature({met}), place_m);
    contact.point_m = place_m - bodies_.constants(body).reach_m * contact.normal;
    return contact;
  }
  if (const PieceContact* found = found_contact(body, k_static | met, event)) return *found;
  return statics_.contact_of_part(met, body, event.feature, event.tick);
}

double Predictions::approach_mps(const EventKey& event) {
  const BodyId a = event.body();
  if (event.is_with_static()) {
    if (!bodies_.is_sphere(a)) return -static_contact_at(a, event.met(), event).rate_mps;
    return -gap_between(statics_.geometry().feature({event.met()}),
                        bodies_.centre_at(a, event.tick), bodies_.constants(a).reach_m)
                .rate_mps;
  }
  const BodyId b = event.other_body();
  if (!bodies_.is_sphere(a) || !bodies_.is_sphere(b)) return -contact_at(a, b, event).rate_mps;
  const Vec3 relative_mps =
      bodies_.centre_at(b, event.tick).velocity_mps - bodies_.centre_at(a, event.tick).velocity_mps;
  return -gap_to_round(bodies_.between_at(a, b, event.tick), relative_mps, 0).rate_mps;
}

}  // namespace sleight::physics
