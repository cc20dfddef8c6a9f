// When balls meet something.
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/physics/marbles/marbles.h"
#include "worker/physics/motion/motion_bounds.h"

namespace sleight::physics {
namespace {

/// Far more than rounding, and than what counts as a touch, does to a place.
constexpr double k_pad_m = 2e-6;

/// A path's box is looked at in halves of halves, so many times, before it is taken to come near
/// another one.
constexpr int k_halvings = 4;

double size_of(const Vec3& v) {
  return std::max({std::fabs(v.x()), std::fabs(v.y()), std::fabs(v.z())});
}

/// Less than the time that a point stays between two walls. REQUIRES: it is between them.
double stays_s(double place, double speed, double pull, double low, double high) {
  constexpr double k_shrink = 1 - 0x1p-30;
  const bool up = speed > 0 || (speed == 0 && pull > 0);
  const double ahead = up ? high - place : place - low;
  const double behind = up ? place - low : high - place;
  const double v = std::fabs(speed);
  const double a = up ? pull : -pull;
  if (a >= 0) {
    if (ahead == std::numeric_limits<double>::infinity()) return ahead;
    const double root = std::sqrt(v * v + 2 * a * ahead);
    return v + root > 0 ? k_shrink * (2 * ahead / (v + root))
                        : std::numeric_limits<double>::infinity();
  }
  const double discriminant = v * v + 2 * a * ahead;
  if (discriminant >= 0) return k_shrink * (2 * ahead / (v + std::sqrt(discriminant)));
  return k_shrink * ((v + std::sqrt(v * v - 2 * a * behind)) / -a);
}

/// Extent of a parabola between two times.
struct Extent {
  double low;
  double high;
};
Extent extent_of(double place, double speed, double pull, double from_s, double to_s) {
  const double first = parabola(place, speed, pull, from_s);
  const double last = parabola(place, speed, pull, to_s);
  Extent extent{std::min(first, last), std::max(first, last)};
  const double first_speed = speed + pull * from_s;
  const double last_speed = speed + pull * to_s;
  if ((first_speed < 0) != (last_speed < 0)) {
    const double apex = place - 0.5 * speed * speed / pull;
    extent.low = std::min(extent.low, apex);
    extent.high = std::max(extent.high, apex);
  }
  return extent;
}

MovingPoint centre_at(const FreeFlight& flight, Tick tick) {
  return {.position_m = position_at(flight, tick),
          .velocity_mps = velocity_at(flight, tick),
          .acceleration_mps2 = flight.acceleration_mps2};
}

/// One look at a pair that may be refractory: examine(touch) judges the tick.
template <class Examine>
Examined examined_at(Tick tick, const Refractory& refractory, const Examine& examine) {
  if (tick >= refractory.until) return examine(k_touch_m);
  const Examined examined = examine(refractory.touch_m);
  if (examined.collides || examined.next <= refractory.until) return examined;
  return {.collides = false, .next = refractory.until};  // from then on, any touch counts again
}

}  // namespace

// ---- static geometry ----------------------------------------------------------------------------

void Marbles::predict_static(std::uint32_t index, Tick from) {
  Ball& ball = balls_[index];
  ball.static_tick = k_never;
  ball.static_feature = k_none;
  if (ball.segment.mode == MotionMode::resting) return;
  const FreeFlight& flight = ball.segment.flight;
  const bool stays = in_contact(ball.segment);
  Tick until = std::min(end_, ball.mode_end);
  for (Tick start = from; start <= until;) {
    // As far as what is near the start is all that is near.
    const MovingPoint centre = centre_at(flight, start);
    const NearFeatures::Cell cell = near_->cell_at(centre.position_m);
    double stay_s = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      stay_s = std::min(
          stay_s, stays_s(centre.position_m[i], centre.velocity_mps[i], centre.acceleration_mps2[i],
                          cell.low_m[axis], cell.high_m[axis]));
    }
    Tick stop = until;
    if (stay_s < seconds(until - start))
      stop = std::min(until, start + std::max<TickCount>(1, ticks_before(stay_s)));
    const double span_s = seconds(stop - start);
    TouchBox path;
    for (int i = 0; i < 3; ++i) {
      const Extent extent = extent_of(centre.position_m[i], centre.velocity_mps[i],
                                      centre.acceleration_mps2[i], 0, span_s);
      const auto axis = static_cast<std::size_t>(i);
      path.low_m[axis] = detail::float_below(extent.low - k_pad_m);
      path.high_m[axis] = detail::float_above(extent.high + k_pad_m);
    }
    const auto ask = [&](std::uint32_t feature) {
      if (!overlaps(path, near_->touch_box(feature))) return;
      // What it stays on it doesn't meet before its mode event.
      if (stays && std::ranges::find(ball.all_supports(), feature) != ball.all_supports().end())
        return;
      const Tick tick = first_touch(index, feature, start, stop);
      if (tick > stop || (tick == ball.static_tick && feature > ball.static_feature)) return;
      ball.static_tick = stop = tick;
      ball.static_feature = feature;
    };
    for (const std::uint32_t feature : near_->strays())
      ask(feature);
    for (const std::uint32_t feature : cell.features)
      ask(feature);
    if (ball.static_feature != k_none) return;
    start = stop + 1;
  }
}

Tick Marbles::first_touch(std::uint32_t index, std::uint32_t feature_index, Tick from,
                          Tick until) const {
  const FreeFlight& flight = balls_[index].segment.flight;
  const SphereFeature& feature = statics_->feature(feature_index);
  const std::span<const RegionSide> sides = statics_->sides(feature);
  if (keeps_clear(feature, sides, centre_at(flight, from), radius_m_, seconds(until + 1 - from)))
    return k_never;
  for (Tick tick = from; tick <= until;) {
    const Examined examined =
        examine(feature, sides, centre_at(flight, tick), radius_m_, k_touch_m, tick);
    if (examined.collides) return tick;
    tick = examined.next;
  }
  return k_never;
}

// ---- two balls ----------------------------------------------------------------------------------

TouchBox Marbles::path_box_of(std::uint32_t index, Tick from, Tick to) const {
  const FreeFlight& flight = balls_[index].segment.flight;
  const double from_s = seconds(from - flight.begin);
  const double to_s = seconds(to - flight.begin);
  TouchBox box;
  for (int i = 0; i < 3; ++i) {
    const Extent extent = extent_of(flight.position_m[i], flight.velocity_mps[i],
                                    flight.acceleration_mps2[i], from_s, to_s);
    const auto axis = static_cast<std::size_t>(i);
    box.low_m[axis] = detail::float_below(extent.low - (radius_m_ + k_pad_m));
    box.high_m[axis] = detail::float_above(extent.high + (radius_m_ + k_pad_m));
  }
  return box;
}

bool Marbles::path_meets(std::uint32_t ball, Tick from, Tick to, const TouchBox& box,
                         int depth) const {
  if (!overlaps(path_box_of(ball, from, to), box)) return false;
  if (depth == k_halvings || to - from < 2) return true;
  const Tick middle = from + (to - from) / 2;
  return path_meets(ball, from, middle, box, depth + 1) ||
         path_meets(ball, middle, to, box, depth + 1);
}

/// When a ball whose motion has changed meets another one, if first; wakes the attention of those
/// that are left alone.
void Marbles::predict_pairs(std::uint32_t index) {
  Ball& ball = balls_[index];
  ball.pair_tick = k_never;
  ball.pair_other = k_none;
  const bool rests = is_resting(index);
  const TouchBox own = boxes_[index];
  for (std::uint32_t other = 0; other < balls_.size(); ++other) {
    if (!overlaps(own, boxes_[other]) || other == index) continue;
    if (balls_[other].suspended) {
      const Tick next = rests ? now_ : std::min({ball.static_tick, ball.mode_end, end_});
      if (balls_[other].resumes || !path_meets(index, now_, next, boxes_[other], 0)) continue;
      balls_[other].resumes = true;
      to_resume_.push_back(other);
      continue;
    }
    if (rests && is_resting(other)) continue;
    const Tick tick = predict_pair(std::min(index, other), std::max(index, other));
    // On a tie the key with the lower ids counts; others come in ascending order.
    if (tick >= ball.pair_tick) continue;
    ball.pair_tick = tick;
    ball.pair_other = other;
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
    // Both fall alike, so the later one's begin and the motion of one against the other decide.
    const Vec3& g = scene_->gravity_mps2;
    const double s = seconds(begin - first.begin);
    const double t = seconds(begin - second.begin);
    Vec3 between_m;
    Vec3 relative_mps;
    for (int i = 0; i < 3; ++i) {
      const double p = parabola(first.position_m[i], first.velocity_mps[i], g[i], s);
      const double q = parabola(second.position_m[i], second.velocity_mps[i], g[i], t);
      between_m[i] = q - p;
      relative_mps[i] = (second.velocity_mps[i] + t * g[i]) - (first.velocity_mps[i] + s * g[i]);
    }
    const TickCount span = collision_of_free_spheres(between_m, relative_mps, radii_m);
    return span >= k_tick_max.value ? k_never : begin + span;
  }
  // Beyond the next change of either nobody asks.
  const auto next = [&](const Ball& ball) { return std::min(ball.static_tick, ball.mode_end); };
  const Tick until = std::min({end_, next(balls_[a]), next(balls_[b])});
  for (Tick tick = std::max(now_, begin); tick <= until;) {
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
