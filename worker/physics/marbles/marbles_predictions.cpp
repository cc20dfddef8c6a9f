// When balls meet something.
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/physics/marbles/marbles.h"
#include "worker/physics/marbles/path_bounds.h"

namespace sleight::physics {
namespace {

/// Far more than rounding, and than what counts as a touch, does to a place.
constexpr double k_pad_m = 2e-6;

/// A path's box is looked at in halves of halves, so many times, before it is taken to come near
/// another one.
constexpr int k_halvings = 5;

using detail::k_forever_s;
using detail::k_root_shrink;

/// A search that is one tick early, as rounding makes some, finds the collision at the next one; so
/// many are judged before it is worth asking for how long it can't collide.
constexpr int k_early_ticks = 2;

/// A corner's region is asked where it is touched; after so many ticks that were too early for a
/// touch, at each.
constexpr int k_steps_without_region = 6;

/// What examine says of a face and a tick, but not for how long.
bool face_collides(const SphereFeature& face, std::span<const RegionSide> sides,
                   const MovingPoint& centre, double radius_m) {
  const Vec3 from = centre.position_m - face.point_m;
  if (math::dot(face.direction, from) - radius_m > k_touch_m) return false;
  if (math::dot(face.direction, centre.velocity_mps) >= -k_approach_mps) return false;
  return std::ranges::all_of(sides, [&](const RegionSide& side) {
    const double inside_m = math::dot(side.space.normal, centre.position_m) - side.space.offset_m;
    return side.strict ? inside_m > 0 : inside_m >= 0;
  });
}

/// For how long an edge or a vertex can't be collided with, by touch and approach as examine judges
/// them: 0 if both hold.
double corner_fails_for_s(const SphereFeature& corner, const MovingPoint& centre, double radius_m,
                          double size_m) {
  Vec3 away_m = centre.position_m - corner.point_m;
  Vec3 velocity_mps = centre.velocity_mps;
  Vec3 pull_mps2 = centre.acceleration_mps2;
  if (corner.kind == FeatureKind::edge) {
    away_m = away_m - math::dot(corner.direction, away_m) * corner.direction;
    velocity_mps = velocity_mps - math::dot(corner.direction, velocity_mps) * corner.direction;
    pull_mps2 = pull_mps2 - math::dot(corner.direction, pull_mps2) * corner.direction;
  }
  const double distance_m = math::norm(away_m);
  const double gap_m = distance_m - radius_m;
  const double c_v = math::dot(away_m, velocity_mps);
  const double rate_mps = c_v / distance_m;
  if (gap_m <= k_touch_m && rate_mps < -k_approach_mps) return 0;
  // The distance is at least that from a plane through the line or point, at right angles to the
  // way there. It doesn't shrink as long as c.v stays positive (sphere_search.h).
  const double c_a = math::dot(away_m, pull_mps2);
  double not_before_s = 0;
  if (rate_mps >= -k_approach_mps) {
    const double v_a = math::dot(velocity_mps, pull_mps2);
    const double c_v_rate = math::dot(velocity_mps, velocity_mps) + c_a;
    const double left = c_v + 0.5 * k_approach_mps * radius_m;
    // left + c_v_rate h + 3/2 v.a h^2 falls to 0.
    if (left > 0) {
      not_before_s = first_fall_s(left, c_v_rate, 3 * v_a);
      if (not_before_s == k_forever_s) return k_forever_s;
    }
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

/// Whether two balls certainly don't touch for a while: their distance is at least that from a
/// plane at right angles to the way between them.
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

/// A part of a path on which what is near stays the same.
struct Marbles::Window {
  Tick start{};
  Tick stop{};
  PathPart path;   ///< from start to stop
  TouchBox box{};  ///< of the centre up to box_stop
  Tick box_stop{};
  void begin(const FreeFlight& flight) {
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
  void make_box() {
    if (box_stop == stop) return;
    box_stop = stop;
    const PathExtent extent =
        extent_of(path.place_m, path.velocity_mps, path.pull_mps2, 0, path.span_s);
    // A float lies within 2^-24 of its number.
    const Four pad_m = Four::axes(k_pad_m + 0x1p-22 * path.size_m);
    box.low_m = floats_of(extent.low_m - pad_m);
    box.high_m = floats_of(extent.high_m + pad_m);
  }
};

void Marbles::predict_static(std::uint32_t index, Tick from) {
  Ball& ball = balls_[index];
  ball.static_tick = k_never;
  ball.static_feature = k_none;
  if (ball.segment.mode == MotionMode::resting) return;
  const FreeFlight& flight = ball.segment.flight;
  std::array<std::uint32_t, 3> stays{k_none, k_none, k_none};
  if (in_contact(ball.segment)) std::ranges::copy(ball.all_supports(), stays.begin());
  std::uint32_t asked = ball.last_feature;
  if (std::ranges::find(stays, asked) != stays.end()) asked = k_none;
  const Tick until = std::min(end_, ball.mode_end);
  const TouchBox* const touch_boxes = near_->touch_boxes().data();
  Tick best_tick = k_never;
  std::uint32_t best = k_none;
  Window window;
  for (window.start = from; window.start <= until; window.start = window.stop + 1) {
    // As far as what is near the start is all that is near.
    window.begin(flight);
    const NearFeatures::Cell cell = near_->cell_at(window.path.place_m);
    const double stay_s = stays_s(window.path.place_m, window.path.velocity_mps,
                                  window.path.pull_mps2, cell.low_m, cell.high_m);
    window.stop = until;
    if (stay_s < seconds(until - window.start))
      window.stop = std::min(until, window.start + std::max<TickCount>(1, ticks_before(stay_s)));
    window.path.lasts(seconds(window.stop - window.start), near_->coordinates_m());
    const auto met = [&](std::uint32_t feature, Tick tick) {
      if (tick > window.stop || (tick == best_tick && feature > best)) return;
      window.ends(tick);
      best_tick = tick;
      best = feature;
    };
    // What it has just left is often what it meets next, and then the rest is too far away.
    if (window.start == from && asked != k_none) {
      const SphereFeature& last = statics_->feature(asked);
      met(asked, last.kind == FeatureKind::face ? first_touch_of_face(flight, last, window)
                                                : first_touch_of_corner(flight, last, window));
    }
    // What it stays on it doesn't meet before its mode event.
    const auto is_done = [&](std::uint32_t feature) {
      return feature == stays[0] || feature == stays[1] || feature == stays[2] ||
             (feature == asked && window.start == from);
    };
    window.box_stop = window.start - 1;
    window.make_box();
    const auto ask = [&](std::uint32_t face) {
      if (!overlaps(window.box, touch_boxes[face]) || is_done(face)) return;
      met(face, first_touch_of_face(flight, statics_->feature(face), window));
    };
    for (const std::uint32_t face : near_->everywhere())
      ask(face);
    for (const std::uint32_t face : cell.faces)
      ask(face);
    // The path is mostly shorter by now.
    window.make_box();
    for (const std::uint32_t corner : cell.corners) {
      if (!overlaps(window.box, touch_boxes[corner]) || is_done(corner)) continue;
      met(corner, first_touch_of_corner(flight, statics_->feature(corner), window));
    }
    if (best != k_none) break;
  }
  ball.static_tick = best_tick;
  ball.static_feature = best;
}

Tick Marbles::first_touch_of_face(const FreeFlight& flight, const SphereFeature& face,
                                  const Window& window) const {
  const PathPart& path = window.path;
  const double after_s = face_not_before_s(path, face, radius_m_);
  if (!(after_s <= path.span_s)) return k_never;
  const std::span<const RegionSide> sides = statics_->sides(face);
  if (stays_outside(sides, path, after_s, path.span_s + k_seconds_per_tick)) return k_never;
  int judged = 0;
  for (Tick tick = window.start + ticks_after(after_s); tick <= window.stop; ++judged) {
    const MovingPoint now = centre_at(flight, tick);
    if (face_collides(face, sides, now, radius_m_)) return tick;
    tick = judged < k_early_ticks ? tick + 1
                                  : examine(face, sides, now, radius_m_, k_touch_m, tick).next;
  }
  return k_never;
}

Tick Marbles::first_touch_of_corner(const FreeFlight& flight, const SphereFeature& corner,
                                    const Window& window) const {
  const PathPart& path = window.path;
  const double after_s = corner_not_before_s(path, corner, radius_m_);
  if (!(after_s <= path.span_s)) return k_never;
  const std::span<const RegionSide> sides = statics_->sides(corner);
  if (stays_outside(sides, path, after_s, path.span_s + k_seconds_per_tick)) return k_never;
  int steps = 0;
  for (Tick tick = window.start + ticks_after(after_s); tick <= window.stop; ++steps) {
    const MovingPoint centre = centre_at(flight, tick);
    double failing_s = corner_fails_for_s(corner, centre, radius_m_, path.size_m);
    if (failing_s == 0 || steps >= k_steps_without_region)
      failing_s = std::max(failing_s, k_root_shrink * outside_for_s(sides, centre));
    if (failing_s == 0) return tick;
    if (!(failing_s <= seconds(window.stop - tick))) return k_never;
    tick = tick + std::max<TickCount>(1, ticks_after(failing_s));
  }
  return k_never;
}

// ---- two balls ----------------------------------------------------------------------------------

TouchBox Marbles::path_box_of(std::uint32_t index, Tick from, Tick to) const {
  const FreeFlight& flight = balls_[index].segment.flight;
  const PathExtent extent = extent_of(Four::of(flight.position_m), Four::of(flight.velocity_mps),
                                      Four::of(flight.acceleration_mps2),
                                      seconds(from - flight.begin), seconds(to - flight.begin));
  // A float lies within 2^-24 of its number.
  const Four pad_m = Four::axes(radius_m_ + k_pad_m);
  const Four low_m = extent.low_m - pad_m;
  const Four high_m = extent.high_m + pad_m;
  const Four rounding = Four::all(0x1p-23);
  return {.low_m = floats_of(low_m - rounding * fabs(low_m)),
          .high_m = floats_of(high_m + rounding * fabs(high_m))};
}

bool Marbles::path_meets(std::uint32_t ball, Tick from, Tick to, const TouchBox& box,
                         int depth) const {
  // Both boxes hold balls: their centres are further in, and touch at two radii.
  const TouchBox path = path_box_of(ball, from, to);
  double square = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double apart_m = std::max(double{path.low_m[i]} - double{box.high_m[i]},
                                    double{box.low_m[i]} - double{path.high_m[i]}) +
                           2 * radius_m_;
    square += apart_m > 0 ? apart_m * apart_m : 0;
  }
  const double reach_m = 2 * (radius_m_ + k_pad_m);
  if (square > reach_m * reach_m) return false;
  if (depth == k_halvings || to - from < 2) return true;
  const Tick middle = from + (to - from) / 2;
  return path_meets(ball, from, middle, box, depth + 1) ||
         path_meets(ball, middle, to, box, depth + 1);
}

/// When a ball whose motion has changed meets another one, if first; wakes the attention of those
/// that are left alone.
void Marbles::predict_pairs(std::uint32_t index) {
  Ball& ball = balls_[index];
  std::uint32_t& partner = partners_[index];
  ball.pair_tick = k_never;
  partner = k_none;
  const bool rests = is_resting(index);
  const TouchBox own = boxes_[index];
  for (std::uint32_t other = 0; other < balls_.size(); ++other) {
    if (!overlaps(own, boxes_[other]) || other == index) continue;
    if (balls_[other].suspended) {
      if (balls_[other].resumes || !path_meets(index, now_, next_of(index), boxes_[other], 0))
        continue;
      balls_[other].resumes = true;
      to_resume_.push_back(other);
      continue;
    }
    if (rests && is_resting(other)) continue;
    const Tick tick = predict_pair(std::min(index, other), std::max(index, other));
    // On a tie the key with the lower ids counts; others come in ascending order.
    if (tick >= ball.pair_tick) continue;
    ball.pair_tick = tick;
    partner = other;
  }
}

Refractory Marbles::refractory_of(std::uint32_t a, std::uint32_t b, Tick begin) const {
  const Refractory refractory = recent_.of(a, b);
  if (refractory.until <= begin) return refractory;
  // In so short a time they don't change their speed by themselves.
  const FreeFlight& first = balls_[a].segment.flight;
  const FreeFlight& second = balls_[b].segment.flight;
  const Vec3 between_m = position_at(second, begin) - position_at(first, begin);
  const Vec3 relative_mps = velocity_at(second, begin) - velocity_at(first, begin);
  const bool fast =
      math::dot(between_m, relative_mps) < -k_fast_approach_mps * math::norm(between_m);
  return fast ? Refractory{} : refractory;
}

Tick Marbles::predict_pair(std::uint32_t a, std::uint32_t b) const {
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
  // Beyond the next change of either nobody asks.
  const Tick until = std::min(is_resting(a) ? end_ : next_of(a), is_resting(b) ? end_ : next_of(b));
  const Tick from = std::max(now_, begin);
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
