#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "worker/physics/marbles/marbles.h"

namespace sleight::physics {
namespace {

/// After this many halvings of a path's box, the path is assumed to come near the other box.
/// Affects speed only.
constexpr int k_halvings = 5;

using detail::k_root_shrink;

/// Paths longer than this (16 ms) usually leave the cell in which they begin. Affects speed only.
constexpr TickCount k_short = TickCount{1} << 24;

/// A ball has settled if it moves by less than this share of its radius. A settled ball stays in
/// its surroundings for several such motions. Affects speed only.
constexpr double k_short_radii = 0.25 * k_settled_radii;

/// The search tests this many ticks before it computes how long no collision is possible. By
/// rounding, some searches start one tick early, and find the collision at the next tick. Affects
/// speed only.
constexpr std::uint64_t k_early_ticks = 2;

/// After this many tested ticks, a corner's region is tested at each tick. Before, it is tested
/// only at touches. Affects speed only.
constexpr std::uint64_t k_steps_without_region = 6;

/// Returns a time for which an edge or a vertex certainly fails examine()'s test of touch or of
/// approach. If it passes both tests, returns 0.
double corner_fails_for_s(const SphereFeature& corner, const MovingPoint& centre, double radius_m,
                          double size_m) {
  Vec3 away_m = centre.position_m - corner.point_m;
  Vec3 velocity_mps = centre.velocity_mps;
  Vec3 pull_mps2 = centre.acceleration_mps2;
  if (corner.kind == FeatureKind::edge) {
    away_m = across(corner, away_m);
    velocity_mps = across(corner, velocity_mps);
    pull_mps2 = across(corner, pull_mps2);
  }
  const double distance_m = math::norm(away_m);
  const double c_v = math::dot(away_m, velocity_mps);
  const auto [gap_m, rate_mps] = gap_at_distance(distance_m, c_v, radius_m);
  if (collides(gap_m, rate_mps)) return 0;
  // Take the plane that contains the line or point and is perpendicular to `away_m`. The distance
  // is at least the distance from this plane. The distance doesn't shrink while c.v is positive
  // (sphere_search.h).
  const double c_a = math::dot(away_m, pull_mps2);
  double not_before_s = 0;
  if (!approaches(rate_mps)) {
    const double v_a = math::dot(velocity_mps, pull_mps2);
    const double c_v_rate = math::dot(velocity_mps, velocity_mps) + c_a;
    const double left = c_v + k_approach_at * k_approach_mps * radius_m;
    // Find where left + c_v_rate h + 3/2 v.a h^2 falls to 0.
    if (left > 0) {
      not_before_s = first_fall_s(left, c_v_rate, 3 * v_a);
      if (not_before_s == k_forever_s) return k_forever_s;
    }
    // The rate falls by at most `pull` per second, so no approach can begin before this bound.
    const double pull = math::norm(pull_mps2);
    if (pull == 0) return k_forever_s;
    not_before_s = std::max(not_before_s, (rate_mps + k_approach_mps) / pull);
  }
  const double excess_m = gap_m - k_touch_m - k_rounding_ulps * (size_m + radius_m);
  const double fails_s = falls_after_s(excess_m, rate_mps, c_a / distance_m, not_before_s);
  return std::max(k_root_shrink * fails_s, k_seconds_per_tick);
}

MovingPoint centre_at(const FreeFlight& flight, Tick tick) {
  return {.position_m = position_at(flight, tick),
          .velocity_mps = velocity_at(flight, tick),
          .acceleration_mps2 = flight.acceleration_mps2};
}

TouchBox ball_box(const PathExtent& extent, double radius_m) {
  // Converting to float changes a number by at most 2^-24 of it.
  const Four pad_m = Four::axes(radius_m + k_place_pad_m);
  const Four low_m = extent.low_m - pad_m;
  const Four high_m = extent.high_m + pad_m;
  const Four rounding = Four::all(0x1p-23);
  return {.low_m = floats_of(low_m - rounding * fabs(low_m)),
          .high_m = floats_of(high_m + rounding * fabs(high_m))};
}

[[gnu::always_inline]] inline TouchBox box_of_way(const FreeFlight& flight, Tick from, Tick to,
                                                  double radius_m) {
  const Four velocity_mps = Four::of(flight.velocity_mps);
  const Four pull_mps2 = Four::of(flight.acceleration_mps2);
  Four first_m = Four::of(flight.position_m);
  Four first_mps = velocity_mps;
  const double to_s = seconds(to - flight.begin);
  const Four last_m = detail::parabolas(first_m, velocity_mps, pull_mps2, to_s);
  if (from != flight.begin) {
    const double from_s = seconds(from - flight.begin);
    first_m = detail::parabolas(first_m, velocity_mps, pull_mps2, from_s);
    first_mps = first_mps + pull_mps2 * Four::all(from_s);
  }
  const PathExtent extent = extent_between(first_m, last_m, first_mps, pull_mps2,
                                           velocity_mps + pull_mps2 * Four::all(to_s));
  return ball_box(extent, radius_m);
}

/// Returns whether two balls certainly don't touch for a time span. Uses the second centre's
/// distance from the plane through the first centre that is perpendicular to `between_m`.
bool stay_apart(const MovingPoint& a, const MovingPoint& b, double radii_m, double span_s) {
  const Vec3 between_m = b.position_m - a.position_m;
  const double square = math::dot(between_m, between_m);
  const double comes = std::min(0.0, math::dot(between_m, b.velocity_mps - a.velocity_mps));
  const double falls =
      std::min(0.0, math::dot(between_m, b.acceleration_mps2 - a.acceleration_mps2));
  const double left = square + comes * span_s + 0.5 * falls * span_s * span_s;
  const double reach_m = radii_m + (k_touch_m + k_clear_margin_m);
  return left > 0 && left * left > reach_m * reach_m * square;
}

}  // namespace

// ---- static geometry ----------------------------------------------------------------------------

/// A part of a path. The set of nearby features is constant on it.
struct Marbles::Window {
  Tick start{};
  Tick stop{};
  PathPart path;                                  ///< from start to stop
  PathExtent extent{Four::zero(), Four::zero()};  ///< of the centre from `begins` to measured_to
  Tick begins{};
  Tick measured_to{-1};
  TouchBox box{};  ///< of the centre with padding, from `begins` to boxed_to
  Tick boxed_to{-1};
  void begin(const FreeFlight& flight) {
    begins = start;
    measured_to = boxed_to = start - 1;
    path.place_m = Four::of(flight.position_m);
    path.velocity_mps = Four::of(flight.velocity_mps);
    path.pull_mps2 = Four::of(flight.acceleration_mps2);
    if (start == flight.begin) return;
    const double s = seconds(start - flight.begin);
    path.place_m = detail::parabolas(path.place_m, path.velocity_mps, path.pull_mps2, s);
    path.velocity_mps = path.velocity_mps + Four::all(s) * path.pull_mps2;
  }
  void ends(Tick tick) {
    stop = tick;
    path.span_s = seconds(stop - start);
  }
  bool is_short() const { return stop - start <= k_short; }
  bool is_within(const NearFeatures::Cell& cell) {
    measure();
    return !is_any_negative(extent.low_m - cell.low_m) &&
           !is_any_negative(cell.high_m - extent.high_m);
  }
  void measure() {
    if (measured_to == stop) return;
    measured_to = stop;
    extent = extent_of(path.place_m, path.velocity_mps, path.pull_mps2, path.span_s);
  }
  /// Returns an upper bound for the sum of the path's extents along the three axes. REQUIRES:
  /// measure() was called.
  double goes_m() const { return sum(extent.high_m - extent.low_m); }
  /// REQUIRES: the path's margins are set.
  void make_box() {
    if (boxed_to == stop) return;
    boxed_to = stop;
    measure();
    path.goes(goes_m());
    // Converting to float changes a number by at most 2^-24 of it.
    const Four pad_m = Four::axes(k_place_pad_m + 0x1p-22 * path.size_m);
    box.low_m = floats_of(extent.low_m - pad_m);
    box.high_m = floats_of(extent.high_m + pad_m);
  }
};

/// Called after a ball's motion has changed. Predicts the ball's next collision with static
/// geometry, and sets the box of its path up to its next event.
void Marbles::predict_static(BodyId index) {
  Marble& ball = balls_[index];
  ball.static_tick = k_never;
  ball.static_feature = k_nothing;
  const FreeFlight& flight = ball.segment.flight;
  if (ball.segment.mode == MotionMode::resting) {
    boxes_.set(index, path_box_of(index, now_, now_));
    if (records_) keep_part(index, boxes_.of(index));
    return;
  }
  // Skip the ball's supports, because the ball can't meet them before its mode event. Test the
  // feature of the last collision first. The ball often meets this feature again, and then the
  // other features are too far away.
  std::array<FeatureId, 4> done{k_nothing, k_nothing, k_nothing, k_nothing};
  if (in_contact(ball.segment)) {
    for (std::uint32_t i = 0; i < ball.supports.count; ++i)
      done[i] = {ball.supports.features[i]};
  }
  const FeatureId last = ball.last_feature;
  if (last != done[0] && last != done[1] && last != done[2]) done[3] = last;
  const Tick until = std::min(end_, ball.supports.end);
  Tick best_tick = k_never;
  FeatureId best = k_nothing;
  Surroundings& surroundings = surroundings_[index];
  Window window;
  const auto met = [&](FeatureId feature, Tick tick) {
    if (tick > window.stop || (tick == best_tick && feature > best)) return;
    window.ends(tick);
    best_tick = tick;
    best = feature;
  };
  // always_inline: function calls would add 2% to a prediction's instructions.
  const auto ask_face = [&](FeatureId index_of_face) __attribute__((always_inline)) {
    const SphereFeature& face = statics_->feature(index_of_face);
    const double after_s = face_not_before_s(window.path, face);
    if (after_s <= window.path.span_s && !stays_outside(statics_->sides(face), window.path, after_s,
                                                        window.path.span_s + k_seconds_per_tick))
      met(index_of_face, meets_face(flight, face, window, after_s));
  };
  const auto ask_corner = [&](FeatureId index_of_corner) __attribute__((always_inline)) {
    const SphereFeature& corner = statics_->feature(index_of_corner);
    const CornerWay way = corner_way(window.path, corner);
    if (way.c_c > window.path.near_m2) return;
    const double after_s = corner_not_before_s(window.path, way, radius_m_);
    if (after_s <= window.path.span_s)
      met(index_of_corner, meets_corner(flight, corner, window, after_s));
  };
  const TouchBox* const touch_boxes = near_->touch_boxes().data();
  // The processor can't predict which features are near, so no branch depends on it. Collect the
  // near features first, and test them afterwards.
  std::array<std::uint32_t, 64> near;
  const auto ask_each = [&](std::span<const FeatureId> features, const auto& ask)
      __attribute__((always_inline)) {
    const TouchBox box = window.box;
    while (!features.empty()) {
      const auto some = features.first(std::min(features.size(), near.size()));
      features = features.subspan(some.size());
      std::size_t count = 0;
      for (const FeatureId feature : some) {
        near[count] = feature;
        count += overlaps(box, touch_boxes[feature]) ? 1 : 0;
      }
      for (const std::uint32_t number : std::span(near).first(count)) {
        const FeatureId feature{number};
        if (feature != done[0] && feature != done[1] && feature != done[2] && feature != done[3])
          ask(feature);
      }
    }
  };
  for (window.start = now_; window.start <= until; window.start = window.stop + 1) {
    // Extend the window as long as only features near its start are near.
    window.begin(flight);
    const bool is_settled = surroundings.holds(window.path.place_m);
    const NearFeatures::Cell cell =
        is_settled ? surroundings.cell() : near_->cell_at(window.path.place_m);
    window.ends(std::min(until, window.start + k_short));
    window.path.sets_margins(near_->coordinates_m(), radius_m_);
    if (done[3] != k_nothing) {
      if (statics_->feature(done[3]).kind == FeatureKind::face) {
        ask_face(done[3]);
      } else {
        ask_corner(done[3]);
      }
    }
    if (best == k_nothing) window.ends(until);
    if (!window.is_short() || !window.is_within(cell)) {
      const double stay_s = stays_s(window.path.place_m, window.path.velocity_mps,
                                    window.path.pull_mps2, cell.low_m, cell.high_m);
      if (stay_s < window.path.span_s)
        window.ends(std::min(until, window.start + std::max<TickCount>(1, ticks_before(stay_s))));
      if (best_tick > window.stop) {
        // Forget a collision beyond the window, because a later window finds it again.
        best_tick = k_never;
        best = k_nothing;
      }
      if (!window.is_short()) {
        // The window is now longer than when the feature was tested.
        window.path.sets_margins(near_->coordinates_m(), radius_m_);
        done[3] = k_nothing;
      }
    }
    window.make_box();
    if (!near_->everywhere().empty()) ask_each(near_->everywhere(), ask_face);
    ask_each(cell.faces, ask_face);
    // Tests of faces have usually shortened the path, so shrink its box.
    window.make_box();
    ask_each(cell.corners, ask_corner);
    window.measure();
    if (!is_settled && window.start == now_ && window.goes_m() < k_short_radii * radius_m_)
      surroundings.settle(*near_, cell, window.path.place_m);
    if (best != k_nothing) break;
    done[3] = k_nothing;
  }
  ball.static_tick = best_tick;
  ball.static_feature = best;
  if (window.begins == now_) {
    boxes_.set(index, ball_box(window.extent, radius_m_));
  } else {
    boxes_.set(index, path_box_of(index, now_, next_of(index)));
  }
  if (records_) keep_part(index, boxes_.of(index));
}

/// Fails the simulation. A search usually takes few ticks. If it reaches the limit, a bound is
/// wrong.
Tick Marbles::gives_up(Tick tick) {
  fail(SceneError::Kind::search_gave_up,
       fmt::format("a collision search examined more than {} ticks, up to tick {} ({:.9g} s)",
                   k_examined_ticks_max, tick.value, seconds(tick - Tick{})));
  return k_never;
}

/// Returns the first tick at which the ball collides with a face. `after_s` is the earliest time at
/// which the ball may touch the face's plane.
Tick Marbles::meets_face(const FreeFlight& flight, const SphereFeature& face, const Window& window,
                         double after_s) {
  const std::span<const RegionSide> sides = statics_->sides(face);
  std::uint64_t judged = 0;
  for (Tick tick = window.start + ticks_after(after_s); tick <= window.stop; ++judged) {
    if (judged > k_examined_ticks_max) return gives_up(tick);
    const MovingPoint now = centre_at(flight, tick);
    const bool hits =
        collides(gap_to_face(face, now.position_m - face.point_m, now.velocity_mps, radius_m_));
    if (hits && is_inside(sides, now.position_m)) return tick;
    if (hits) {
      // The ball is below the plane and outside the face's region, but may still enter the region.
      const double outside_s = k_root_shrink * outside_for_s(sides, now);
      if (!(outside_s <= seconds(window.stop - tick))) return k_never;
      tick = tick + std::max<TickCount>(1, ticks_after(outside_s));
    } else {
      tick = judged < k_early_ticks ? tick + 1 : examine(face, sides, now, radius_m_, tick).next;
    }
  }
  return k_never;
}

/// Returns the first tick at which the ball collides with an edge or a vertex. `after_s` is the
/// earliest time of a touch.
Tick Marbles::meets_corner(const FreeFlight& flight, const SphereFeature& corner,
                           const Window& window, double after_s) {
  const PathPart& path = window.path;
  const std::span<const RegionSide> sides = statics_->sides(corner);
  std::uint64_t judged = 0;
  for (Tick tick = window.start + ticks_after(after_s); tick <= window.stop; ++judged) {
    if (judged > k_examined_ticks_max) return gives_up(tick);
    const MovingPoint now = centre_at(flight, tick);
    const bool hits = collides(gap_between(corner, now, radius_m_));
    if (hits && is_inside(sides, now.position_m)) return tick;
    TickCount skips = 1;
    if (hits || judged >= k_early_ticks) {
      if (judged == 0 && stays_outside(sides, path, after_s, path.span_s + k_seconds_per_tick))
        return k_never;
      // Test the region's sides only if the ball touches, or if several ticks have been tested.
      double failing_s = hits ? 0 : corner_fails_for_s(corner, now, radius_m_, path.size_m);
      if (hits || judged >= k_steps_without_region)
        failing_s = std::max(failing_s, k_root_shrink * outside_for_s(sides, now));
      if (!(failing_s <= seconds(window.stop - tick))) return k_never;
      skips = std::max(skips, ticks_after(failing_s));
    }
    tick = tick + skips;
  }
  return k_never;
}

/// Returns the first tick from `from` to `until` at which a ball meets a changed feature, or
/// k_never. Computes this tick as predict_static does.
Tick Marbles::first_met(const FreeFlight& flight, Tick from, Tick until,
                        const MarbleChange& change) {
  Window window;
  window.start = from;
  window.begin(flight);
  window.ends(until);
  window.path.sets_margins(near_->coordinates_m(), radius_m_);
  window.make_box();
  Tick first = k_never;
  for (const FeatureId index : change.features) {
    if (!overlaps(window.box, near_->touch_boxes()[index])) continue;
    const SphereFeature& feature = statics_->feature(index);
    if (feature.kind == FeatureKind::face) {
      const double after_s = face_not_before_s(window.path, feature);
      if (after_s <= window.path.span_s)
        first = std::min(first, meets_face(flight, feature, window, after_s));
    } else {
      const CornerWay way = corner_way(window.path, feature);
      const double after_s = corner_not_before_s(window.path, way, radius_m_);
      if (after_s <= window.path.span_s)
        first = std::min(first, meets_corner(flight, feature, window, after_s));
    }
  }
  return first;
}

// ---- two balls ----------------------------------------------------------------------------------

TouchBox Marbles::way_box_of(const FreeFlight& flight, Tick from, Tick to) const {
  return box_of_way(flight, from, to, radius_m_);
}

bool Marbles::way_meets(const FreeFlight& flight, Tick from, Tick to, const TouchBox& box,
                        int depth) const {
  // Both boxes contain whole balls, so the centres are at least a radius inside the boxes. When the
  // balls touch, the centres are two radii apart.
  const double reach_m = 2 * (radius_m_ + k_place_pad_m);
  if (apart_m2(box_of_way(flight, from, to, radius_m_), box, radius_m_) > reach_m * reach_m)
    return false;
  if (depth == k_halvings || to - from < 2) return true;
  const Tick middle = from + (to - from) / 2;
  return way_meets(flight, from, middle, box, depth + 1) ||
         way_meets(flight, middle, to, box, depth + 1);
}

/// Called after a ball's motion has changed. Predicts the ball's next collision with another ball.
/// If balls near its path are left alone, makes them catch up.
void Marbles::predict_pairs(BodyId index) {
  balls_[index].pair_tick = k_never;
  partners_[index] = k_none;
  const TouchBox own = boxes_.of(index);
  boxes_.for_each_overlapping(own, [&](BodyId other) {
    if (other != index) comes_near(index, own, other);
  });
  if (!replays_.empty()) {
    const bool rests = is_resting(index);
    comes_near_replayed(index, own, rests ? end_ : next_of(index), !rests);
  }
}

/// Handles a ball whose path may come near another ball, or near the other ball's confinement.
void Marbles::comes_near(BodyId index, const TouchBox& own, BodyId other) {
  if (balls_[other].suspended) {
    if (balls_[other].resumes || !path_meets(index, now_, next_of(index), boxes_.of(other), 0))
      return;
    balls_[other].resumes = true;
    to_resume_.push_back(other);
    return;
  }
  if (is_resting(index) && is_resting(other)) return;
  // Boxes may overlap only in their corners, where no ball is.
  const double reach_m = 2 * (radius_m_ + k_place_pad_m);
  if (apart_m2(own, boxes_.of(other), radius_m_) > reach_m * reach_m) return;
  const Tick tick = predict_pair(std::min(index, other), std::max(index, other));
  // If ticks are equal, the key with the lower ids counts. The loop visits balls in ascending
  // order.
  if (tick >= balls_[index].pair_tick) return;
  balls_[index].pair_tick = tick;
  partners_[index] = other;
}

Refractory Marbles::refractory_of(BodyId a, BodyId b, Tick begin) const {
  const Refractory refractory = recent_.of(a, b);
  if (refractory.until <= begin) return refractory;
  // The refractory time is so short that free motion hardly changes the balls' speeds.
  const FreeFlight& first = balls_[a].segment.flight;
  const FreeFlight& second = balls_[b].segment.flight;
  const Vec3 between_m = position_at(second, begin) - position_at(first, begin);
  const Vec3 relative_mps = velocity_at(second, begin) - velocity_at(first, begin);
  const bool fast =
      math::dot(between_m, relative_mps) < -k_fast_approach_mps * math::norm(between_m);
  return fast ? Refractory{} : refractory;
}

Tick Marbles::predict_pair(BodyId a, BodyId b) const {
  const Segment& segment_a = balls_[a].segment;
  const Segment& segment_b = balls_[b].segment;
  const FreeFlight& first = segment_a.flight;
  const FreeFlight& second = segment_b.flight;
  const Tick begin = std::max(first.begin, second.begin);
  const Refractory refractory = refractory_of(a, b, begin);
  const double radii_m = radius_m_ + radius_m_;
  if (segment_a.mode == MotionMode::free && segment_b.mode == MotionMode::free &&
      refractory.until <= begin) {
    return collision_of_flights(first, second, scene_->gravity_mps2, Vec3(0, 0, 0), radii_m);
  }
  // Collisions after the next change of either ball are not needed.
  const Tick until = std::min(is_resting(a) ? end_ : next_of(a), is_resting(b) ? end_ : next_of(b));
  const Tick from = std::max(now_, begin);
  return first_touch(first, second, from, until, refractory);
}

/// Returns the first tick from `from` to `until` at which two balls collide, or k_never.
Tick Marbles::first_touch(const FreeFlight& first, const FreeFlight& second, Tick from, Tick until,
                          const Refractory& refractory) const {
  const double radii_m = radius_m_ + radius_m_;
  if (from <= until &&
      stay_apart(centre_at(first, from), centre_at(second, from), radii_m, seconds(until - from)))
    return k_never;
  for (Tick tick = from; tick <= until;) {
    const MovingPoint p = centre_at(first, tick);
    const MovingPoint q = centre_at(second, tick);
    const MovingPoint relative{.position_m = q.position_m - p.position_m,
                               .velocity_mps = q.velocity_mps - p.velocity_mps,
                               .acceleration_mps2 = q.acceleration_mps2 - p.acceleration_mps2};
    const double coordinates_m = std::max(size_of(p.position_m), size_of(q.position_m));
    const Examined examined = examined_at(tick, refractory, [&](double touch_m) {
      return examine_spheres(relative, radii_m, coordinates_m, touch_m, tick);
    });
    if (examined.collides) return tick;
    tick = examined.next;
  }
  return k_never;
}

}  // namespace sleight::physics
