// Implements templates of engine.h that decide how long bounding volumes last and find what is near
// them.
#pragma once

#include <algorithm>
#include <cmath>

#include "worker/physics/motion/motion_bounds.h"
#include "worker/physics/simulator/engine.h"

namespace sleight::physics {

// All constants below affect only speed.

/// Minimum duration of a new box: the time in which its body moves by this share of the body's
/// radius. Boxes with shorter durations would expire more often and still overlap as many boxes.
inline constexpr double k_least_box_radii = 0.2;
/// Maximum duration of a box: the time in which its body moves by this many radii. With a longer
/// duration, the box would be larger and on a higher grid level than most boxes. Then every move
/// would have to search that level too.
inline constexpr double k_most_box_radii = 2.5;
/// Maximum duration if a body has many static features near it. Each change of motion must predict
/// all features in the box, and a smaller box contains fewer.
inline constexpr double k_most_box_radii_among_many = 0.7;
inline constexpr std::size_t k_many_statics = 12;
/// A box is padded on each side of its body's path by this share of the body's radius. So the box
/// usually still contains the body for a while after a collision.
inline constexpr double k_box_pad_radii = 0.2;
/// When a body's motion changes, it keeps its box if it will stay inside while it moves by this
/// share of its radius.
inline constexpr double k_keep_box_radii = 0.05;
/// Each box should overlap about this many boxes. The duration of a new box is that of the last
/// box, times this target, divided by the number of boxes that the last box overlapped. The two
/// factors below limit the change. The target balances the cost of predictions against the cost of
/// new boxes.
inline constexpr double k_neighbours_wanted = 6;
inline constexpr double k_span_factor_min = 0.5;
inline constexpr double k_span_factor_max = 1.3;
/// Boxes for searching static features have this margin, as a share of the body's radius. So most
/// new boxes are within the last such box, and no new search is needed.
inline constexpr double k_static_margin_radii = 0.7;
/// Maximum duration of boxes in the synchronous algorithm: no body moves by more than this many of
/// its radii in this time.
inline constexpr double k_synchronous_step_radii = 1;

inline bool holds(const Box& outer, const Box& inner) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (inner.low_m[axis] < outer.low_m[axis] || inner.high_m[axis] > outer.high_m[axis])
      return false;
  }
  return true;
}

inline Box wider(const Box& box, float margin_m) {
  Box wide;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    wide.low_m[axis] = box.low_m[axis] - margin_m;
    wide.high_m[axis] = box.high_m[axis] + margin_m;
  }
  return wide;
}

/// Returns about how long a body takes, from a tick on, to move by a given number of its radii.
inline TickCount span_of_travel(const Bodies& bodies, BodyId body, Tick tick, double radii) {
  const Path flight = bodies.path(body);
  const double way_m = radii * bodies.reach_m(body);
  // Use sums of components instead of norms; this affects only the boxes' duration.
  const Vec3& pull = flight.acceleration_mps2;
  const Vec3 velocity_mps = flight.velocity_mps + seconds(tick - flight.begin) * pull;
  const double speed_mps =
      (std::fabs(velocity_mps.x()) + std::fabs(velocity_mps.y())) + std::fabs(velocity_mps.z());
  const double a = (std::fabs(pull.x()) + std::fabs(pull.y())) + std::fabs(pull.z());
  const double rate =
      a == 0 ? 2 * speed_mps : speed_mps + std::sqrt(speed_mps * speed_mps + 2 * a * way_m);
  return rate > 0 ? ticks_after(2 * way_m / rate) : k_tick_max.value;
}

/// Limits the span of a body's box, which contains its path and padding. In a periodic world, if
/// two bodies' boxes overlap, the bodies must be nearer to each other than to each other's images:
/// Bodies::to_nearest_image requires this. The distance between the centres of two such bodies is
/// at most the sum of both boxes' edges minus both radii. limited_span() keeps this distance below
/// half a period.
inline TickCount limited_span(const Bodies& bodies, BodyId body, Tick tick, TickCount span,
                              double pad_radii) {
  TickCount limited = std::min(span, k_tick_max - tick);
  if (!bodies.periodic()) return limited;
  const Flight& flight = bodies.flight(body);
  for (int i = 0; i < 3; ++i) {
    const double period = bodies.scene().period_m[static_cast<std::size_t>(i)];
    const double speed_mps = std::fabs(flight.velocity_mps[i]);
    if (period == 0 || speed_mps == 0) continue;
    // Each of the two bodies gets a quarter of the period, minus a hundredth of the period for
    // rounding.
    const double way_m = 0.24 * period - (1 + 2 * pad_radii) * bodies.reach_m(body);
    limited = std::min(limited, ticks_before(way_m / speed_mps));
  }
  return std::max<TickCount>(1, limited);
}

inline double typical_box_m(const Bodies& bodies) {
  double sum_m = 0;
  std::uint32_t count = 0;
  for (BodyId body{}; body < bodies.size(); ++body) {
    if (bodies.is_fixed(body)) continue;
    sum_m += 2 * bodies.constants(body).reach_m;
    ++count;
  }
  return count == 0 ? 1 : 1.3 * sum_m / count;
}

/// Updates a body that began a segment at this tick. The body keeps its box if it will stay inside
/// for long enough.
template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::motion_changed(BodyId body) {
  if (options_.algorithm == Algorithm::asynchronous) {
    const Tick exit =
        exit_tick(boxes_.box({body}), bodies_.path(body), bodies_.reach_m(body) + k_touch_m, now_);
    if (exit - now_ >= span_of_travel(bodies_, body, now_, k_keep_box_radii)) {
      bounds_[body].expiry = exit + 1;
    } else {
      renew_box(body, false);
    }
  }
  predict_all(body);
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::renew_box(BodyId body, bool predict_new) {
  // The new box lasts the time since the last box was made, times a factor. In the thesis the
  // factor is 2. Here it depends on the number of boxes that the last box overlapped.
  Bound& bound = bounds_[body];
  const auto neighbours = static_cast<double>(graph_.others_of(body).size());
  const double factor =
      std::clamp(k_neighbours_wanted / (neighbours + 1e-3), k_span_factor_min, k_span_factor_max);
  const auto wanted = static_cast<TickCount>(factor * static_cast<double>(now_ - bound.made));
  const bool among_many = bodies_.is_sphere(body) && candidates_[body].size() > k_many_statics;
  const double most_radii = among_many ? k_most_box_radii_among_many : k_most_box_radii;
  const TickCount span = std::min(std::min(std::max(wanted, least_span(body)), k_tick_max - now_),
                                  span_of_travel(bodies_, body, now_, most_radii));
  const double radius_m = bodies_.reach_m(body) * (1 + k_box_pad_radii) + k_touch_m;
  const Tick end = now_ + limited_span(bodies_, body, now_, span, k_box_pad_radii);
  const Box box = path_box(bodies_.path(body), radius_m, now_, end);
  bound = {.expiry = std::max(end, exit_tick(box, bodies_.path(body),
                                             bodies_.reach_m(body) + k_touch_m, now_)) +
                     1,
           .made = now_};
  Sink sink{*this, body, predict_new};
  boxes_.move({body}, box, sink);
  replaying_.comes_into(body, box);
  if (predict_new) fetch_next_neighbours();
  watch_statics(body, box);
  if (!predict_new) return;
  // Some static searches stopped at the last box's expiry. Continue them.
  for (StaticEdge& edge : statics_of(body)) {
    if (edge.prediction.certain || edge.prediction.tick > now_ + 1) continue;
    ++counts_.predictions;
    edge.prediction = predictions_.look_static(body, edge.index, now_, edge.search, bound.expiry);
  }
  sink.finish();
  refresh_key(body);
}

/// Updates the list of static features that the body may meet in a box. Selects them from the
/// candidates in a wider box. Returns whether the list changed.
template <BroadPhase Boxes, EventQueue Queue>
bool Engine<Boxes, Queue>::watch_statics(BodyId body, const Box& box) {
  if (!world_.statics().any() || world_.statics().count(body) == 0) return false;
  if (world_.replayed().has(body)) return false;
  if (!holds(static_boxes_[body], box)) {
    // If the new box is far outside the last wide one, use no margin: the fast body would leave a
    // wide box at once.
    const auto margin = static_cast<float>(k_static_margin_radii * bodies_.reach_m(body));
    Box& wide = static_boxes_[body];
    wide = wider(box, holds(wider(wide, margin), box) ? margin : 0);
    std::vector<StaticId>& candidates = candidates_[body];
    candidates.clear();
    world_.statics().near(body, wide, candidates);
  }
  near_.clear();
  world_.statics().in(body, box, candidates_[body], near_);
  std::vector<StaticEdge>& list = statics_[body];
  if (std::ranges::equal(list, near_, {}, &StaticEdge::index)) return false;
  // If a feature was already watched, it keeps its prediction. Both lists are ascending.
  const std::size_t before = list.size();
  std::size_t old = 0;
  for (const StaticId index : near_) {
    for (; old < before && list[old].index < index; ++old)
      predictions_.end_search(list[old].search);
    if (old < before && list[old].index == index) {
      const StaticEdge kept = list[old++];
      list.push_back(kept);
    } else {
      StaticEdge edge{.index = index};
      ++counts_.predictions;
      edge.prediction =
          predictions_.predict_static(body, index, now_, edge.search, bounds_[body].expiry);
      list.push_back(edge);
    }
  }
  for (; old < before; ++old)
    predictions_.end_search(list[old].search);
  list.erase(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(before));
  return true;
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::renew_all_boxes(Tick end) {
  boxes_until_ = k_never;
  if (failure_ || present_ == 0) return;
  // Boxes last until the next event. Boxes also have a maximum duration, because the next event may
  // be far away.
  TickCount step = k_tick_max.value;
  for (BodyId body{}; body < bodies_.size(); ++body) {
    if (bodies_.started(body))
      step = std::min(step, span_of_travel(bodies_, body, now_, k_synchronous_step_radii));
  }
  queue_.set(slot_of(OwnSlot::new_boxes), {.tick = now_ + std::max<TickCount>(step, 1),
                                           .kind = EventKind::update,
                                           .lower = k_nobody,
                                           .higher = k_nobody});
  const Tick next = std::min(queue_.least().key.tick, end);
  boxes_until_ = std::max(next, now_);
  for (BodyId body{}; body < bodies_.size(); ++body) {
    if (!bodies_.started(body)) continue;
    all_boxes_[body] =
        path_box(bodies_.path(body), bodies_.reach_m(body) + k_touch_m, now_, std::max(next, now_));
    replaying_.comes_into(body, all_boxes_[body]);
    if (watch_statics(body, all_boxes_[body])) refresh_key(body);
  }
  PairsSink sink{*this};
  boxes_.move_all(all_boxes_, sink);
  // If the next event has become void, the boxes still last only until that event's tick.
  if (queue_.least().key.tick > next && next < end) {
    queue_.set(slot_of(OwnSlot::new_boxes),
               {.tick = next, .kind = EventKind::update, .lower = k_nobody, .higher = k_nobody});
  }
}

template <BroadPhase Boxes, EventQueue Queue>
TickCount Engine<Boxes, Queue>::least_span(BodyId body) const {
  return span_of_travel(bodies_, body, now_, k_least_box_radii);
}

}  // namespace sleight::physics
