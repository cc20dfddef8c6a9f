// When bodies meet.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/physics/simulator/world.h"

namespace sleight::physics {
namespace {

/// A search goes on for so many looks before it waits for the time at which the next one is due:
/// most pairs change their motion before.
constexpr int k_looks_ahead = 32;

/// In place of a feature: the search exceeded its limit.
constexpr std::uint32_t k_gave_up = UINT32_MAX;

/// A few looks of a search without a state, from a tick on.
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

/// Goes on with the searches of a pair's parts up to `now`. examine(i, tick, search) looks at the
/// i-th pair of parts. The first collision counts, of the parts with the least number.
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

void World::note_failure(SceneError::Kind kind, const std::string& what, std::uint32_t body,
                         Tick tick) {
  if (failure_) return;
  failure_ = SceneError{kind, fmt::format("{}: {} at tick {} ({:.9g} s)", name(body), what,
                                          tick.value, seconds(tick - Tick{}))};
}

void World::note_search_gave_up(std::uint32_t body, Tick tick) {
  note_failure(SceneError::Kind::search_gave_up, "the search for a collision gives up", body, tick);
}

// ---- two bodies ---------------------------------------------------------------------------------

Prediction World::predict(std::uint32_t a, std::uint32_t b, Tick now, std::uint32_t& search) {
  const Tick begin = std::max(flights_[a].begin, flights_[b].begin);
  const bool both_free =
      segments_[a].mode == MotionMode::free && segments_[b].mode == MotionMode::free;
  if (constants_[a].is_sphere && constants_[b].is_sphere) {
    const bool closed = both_free && refractory_of_spheres(a, b).until <= begin;
    return closed ? predict_free_spheres(a, b, now) : predict_spheres(a, b, now);
  }
  if (segments_[a].mode == MotionMode::resting && segments_[b].mode == MotionMode::resting)
    return {};
  const std::size_t pairs =
      std::size_t{constants_[a].part_count} * std::size_t{constants_[b].part_count};
  // Nothing to look for while both stay near places in which they are clear of each other.
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
  // First stage: the spheres that hold them.
  TickCount span = 0;
  if (both_free) {
    const MovingPoint first = centre_at(a, begin);
    const MovingPoint second = centre_at(b, begin);
    span = touch_of_free_spheres(second.position_m - first.position_m,
                                 second.velocity_mps - first.velocity_mps,
                                 constants_[a].reach_m + constants_[b].reach_m);
    if (span >= k_tick_max.value) return {};
  }
  // Second stage: the parts.
  for (PieceSearch& part : searches_.fresh(search, pairs))
    part.next = begin + span;
  return look(a, b, now, search);
}

Prediction World::look(std::uint32_t a, std::uint32_t b, Tick now, std::uint32_t search) {
  if (constants_[a].is_sphere && constants_[b].is_sphere) return predict_spheres(a, b, now);
  const std::uint32_t of_b = constants_[b].part_count;
  // Most looks come after it.
  Refractory refractory = recent_.of(a, b);
  bool asked = false;
  const bool several = searches_.of(search).size() > 1;
  const double reach_a_m = constants_[a].reach_m;
  const double reach_b_m = constants_[b].reach_m;
  const Prediction prediction = advanced(
      searches_.of(search), now, [&](std::uint32_t i, Tick tick, PieceSearch& search_of_parts) {
        PieceContact contact;
        if (tick <= refractory.until && !asked) {
          refractory = refractory_of_parts(a, b);
          asked = true;
        }
        const Examined examined = examined_at(tick, refractory, [&](double touch_m) {
          Examined apart;
          if (spheres_apart(centre_at(a, tick), centre_at(b, tick), reach_a_m + reach_b_m,
                            std::min(reach_a_m, reach_b_m), tick, apart))
            return apart;
          if (several && hulls_apart(a, b, tick, touch_m, search_of_parts.cache, apart))
            return apart;
          return examine_pieces(part_at(a, i / of_b, tick), part_at(b, i % of_b, tick), tick,
                                touch_m, search_of_parts.cache, contact);
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
  if (prediction.feature == k_gave_up) note_search_gave_up(a, now);
  return prediction;
}

bool World::hulls_apart(std::uint32_t a, std::uint32_t b, Tick tick, double touch_m,
                        SeparationCache& cache, Examined& examined) {
  HullLook& look = hull_look_;
  if (look.tick != tick || look.a != a || look.b != b || look.touch_m != touch_m) {
    const auto hull_at = [&](std::uint32_t body, MovingPiece& piece) {
      piece = part_at(body, 0, tick);
      if (constants_[body].part_count == 1) return true;
      if (constants_[body].hull == BodyConstants::k_no_hull) return false;
      piece.view = &hulls_[constants_[body].hull];
      return true;
    };
    look = {.tick = tick, .a = a, .b = b, .touch_m = touch_m, .apart = false, .examined = {}};
    MovingPiece first;
    MovingPiece second;
    if (hull_at(a, first) && hull_at(b, second) && (is_round(first) || is_round(second))) {
      PieceContact contact;
      look.examined = examine_pieces(first, second, tick, touch_m, cache, contact);
      look.apart = !look.examined.collides && look.examined.gap_m > touch_m;
    }
  }
  examined = look.examined;
  return look.apart;
}

Refractory World::refractory_of_parts(std::uint32_t a, std::uint32_t b) {
  const Refractory refractory = recent_.of(a, b);
  const Tick begin = std::max(flights_[a].begin, flights_[b].begin);
  if (refractory.until <= begin) return refractory;
  // As for spheres, at the closest points of any two parts; mostly nothing of them is fast.
  const MovingPiece& first = moving_at(a, begin);
  const MovingPiece& second = moving_at(b, begin);
  const double turning_mps = constants_[a].reach_m * math::norm(first.angular_velocity_radps) +
                             constants_[b].reach_m * math::norm(second.angular_velocity_radps);
  if (math::norm(second.velocity_mps - first.velocity_mps) + turning_mps < k_fast_approach_mps)
    return refractory;
  for (std::uint32_t i = 0; i < constants_[a].part_count; ++i) {
    for (std::uint32_t j = 0; j < constants_[b].part_count; ++j) {
      const PieceContact contact = contact_of(part_at(a, i, begin), part_at(b, j, begin));
      if (touches(contact.gap_m) && contact.rate_mps < -k_fast_approach_mps) return {};
    }
  }
  return refractory;
}

Refractory World::refractory_of_spheres(std::uint32_t a, std::uint32_t b) const {
  const Refractory refractory = recent_.of(a, b);
  const Tick begin = std::max(flights_[a].begin, flights_[b].begin);
  if (refractory.until <= begin) return refractory;
  // In so short a time they don't change their speed by themselves.
  const Vec3 between_m = between_at(a, b, begin);
  const Vec3 relative_mps =
      velocity_at(segments_[b].flight, begin) - velocity_at(segments_[a].flight, begin);
  const bool fast =
      math::dot(between_m, relative_mps) < -k_fast_approach_mps * math::norm(between_m);
  return fast ? Refractory{} : refractory;
}

Prediction World::predict_spheres(std::uint32_t a, std::uint32_t b, Tick from) const {
  if (segments_[a].mode == MotionMode::resting && segments_[b].mode == MotionMode::resting)
    return {};
  const double radii_m = constants_[a].reach_m + constants_[b].reach_m;
  const Refractory refractory = refractory_of_spheres(a, b);
  return looked_ahead(from, k_never, [&](Tick tick) {
    const MovingPoint p = centre_at(a, tick);
    const MovingPoint q = centre_at(b, tick);
    const MovingPoint relative{.position_m = between_at(a, b, tick),
                               .velocity_mps = q.velocity_mps - p.velocity_mps,
                               .acceleration_mps2 = q.acceleration_mps2 - p.acceleration_mps2};
    const double coordinates_m = std::max(size_of(p.position_m), size_of(q.position_m));
    return examined_at(tick, refractory, [&](double touch_m) {
      return examine_spheres(relative, radii_m, coordinates_m, touch_m, tick);
    });
  });
}

// ---- images -------------------------------------------------------------------------------------

Prediction World::predict_any_image(std::uint32_t a, std::uint32_t b, Tick now) const {
  // Images one period away from the nearest are all that can be met before the two have moved by
  // half a period against one another.
  const Vec3 between_m =
      position_at(segments_[b].flight, now) - position_at(segments_[a].flight, now);
  const Vec3 nearest_m = to_nearest_image(between_m);
  const Vec3 relative_mps =
      velocity_at(segments_[b].flight, now) - velocity_at(segments_[a].flight, now);
  double half_m = std::numeric_limits<double>::infinity();
  for (const double period : scene_.period_m) {
    if (period > 0) half_m = std::min(half_m, 0.5 * period);
  }
  const double speed_mps = math::norm(relative_mps);
  Prediction first;
  if (speed_mps > 0) first.tick = now + std::max<TickCount>(1, ticks_before(half_m / speed_mps));
  const auto reach = [&](std::size_t axis) { return scene_.period_m[axis] > 0 ? 1 : 0; };
  for (int x = -reach(0); x <= reach(0); ++x) {
    for (int y = -reach(1); y <= reach(1); ++y) {
      for (int z = -reach(2); z <= reach(2); ++z) {
        const Vec3 shift_m = nearest_m + Vec3(x * scene_.period_m[0], y * scene_.period_m[1],
                                              z * scene_.period_m[2]);
        const Prediction prediction = predict_free_spheres_at(a, b, shift_m);
        if (prediction.tick < now || prediction.tick > first.tick) continue;
        first = prediction;
      }
    }
  }
  return first;
}

// ---- a body and static geometry -----------------------------------------------------------------

Prediction World::predict_static(std::uint32_t body, std::uint32_t index, Tick now,
                                 std::uint32_t& search, Tick until) {
  if (segments_[body].mode == MotionMode::resting) return {};
  if (constants_[body].is_sphere) return look_static(body, index, now, search, until);
  if (stays_on_faces(body) && supports_[body].holds(index)) return {};
  for (PieceSearch& part : searches_.fresh(search, constants_[body].part_count))
    part.next = flights_[body].begin;
  return look_static(body, index, now, search, until);
}

Prediction World::look_static(std::uint32_t body, std::uint32_t index, Tick now,
                              std::uint32_t search, Tick until) {
  if (!constants_[body].is_sphere) {
    const Prediction prediction = advanced(
        searches_.of(search), now, [&](std::uint32_t part, Tick tick, PieceSearch& search_of_part) {
          PieceContact contact;
          const auto examine_part = [&] {
            if (is_surface(body, index)) {
              MetSurface& met = surface(index);
              NearPoints& near = met.near[constants_[body].first_part + part];
              if (search_of_part.looks == 1) near.forget_motion();
              return examine_surface(met.surface, lattice_on(index, body, part),
                                     part_at(body, part, tick), tick, near, contact);
            }
            if (index >= statics_.plane_count()) {
              return examine_pieces(statics_.piece(index), part_at(body, part, tick), tick,
                                    k_touch_m, search_of_part.cache, contact);
            }
            Examined above;
            if (sphere_above(statics_.plane(index), centre_at(body, tick), constants_[body].reach_m,
                             tick, above))
              return above;
            return examine_plane(statics_.plane(index), part_at(body, part, tick), tick, k_touch_m,
                                 contact);
          };
          const Examined examined = examine_part();
          if (examined.collides) found_ = {tick, body, k_static | index, part, contact};
          return examined;
        });
    if (prediction.feature == k_gave_up) note_search_gave_up(body, now);
    return prediction;
  }
  // What it stays on it doesn't meet before its mode event.
  if (stays_on_faces(body) && supports_[body].holds(index)) return {};
  const SphereFeature& feature = statics_.feature(index);
  const double radius_m = constants_[body].reach_m;
  if (until < k_tick_max && keeps_clear(feature, statics_.sides(feature), centre_at(body, now),
                                        radius_m, seconds(until + 1 - now)))
    return {.tick = until + 1, .certain = false};
  return looked_ahead(now, until, [&](Tick tick) {
    return examine(feature, statics_.sides(feature), centre_at(body, tick), radius_m, tick);
  });
}

}  // namespace sleight::physics
