// How long bounding volumes last, and what is near them: bodies of the templates in engine.h.
#pragma once

#include <algorithm>
#include <cmath>

#include "worker/physics/motion/motion_bounds.h"
#include "worker/physics/simulator/engine.h"

namespace sleight::physics {

// All of these change speed only.

/// A new box lasts at least as long as its body takes for this share of its radius: shorter ones
/// expire often and keep no more pairs apart.
inline constexpr double k_least_box_radii = 0.2;
/// It lasts at most as long as its body takes for so many radii. A longer box would be on another
/// level of the grid than most, which every move had to search as well.
inline constexpr double k_most_box_radii = 2.5;
/// The same for a body with many static features near it: the fewer a box holds, the fewer are
/// asked for at each change of motion.
inline constexpr double k_most_box_radii_among_many = 0.7;
inline constexpr std::size_t k_many_statics = 12;
/// A box is wider than its body's path by this share of the body's radius on each side, so that it
/// holds the body for a while after a collision as well.
inline constexpr double k_box_pad_radii = 0.2;
/// After a change of motion the box is kept if it holds the body for the time in which that moves
/// by this share of its radius.
inline constexpr double k_keep_box_radii = 0.05;
/// A new box lasts longer than the last one did if that overlapped less others than this, shorter
/// if more, in proportion and within these factors: neighbours must be predicted, and boxes made.
inline constexpr double k_neighbours_wanted = 6;
inline constexpr double k_span_factor_min = 0.5;
inline constexpr double k_span_factor_max = 1.3;
/// Boxes in which static features are looked for are larger by this share of the body's radius, so
/// that most new boxes lie within the last such box.
inline constexpr double k_static_margin_radii = 0.7;
/// A box of the synchronous algorithm lasts at most as long as the fastest body takes for its
/// radius.
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

/// Within what time, to be counted from a tick, a body may move by a number of its radii.
inline TickCount span_of_travel(const Bodies& bodies, BodyId body, Tick tick, double radii) {
  const Path flight = bodies.path(body);
  const double way_m = radii * bodies.reach_m(body);
  // Sums of components in place of norms: this sets speed only.
  const Vec3& pull = flight.acceleration_mps2;
  const Vec3 velocity_mps = flight.velocity_mps + seconds(tick - flight.begin) * pull;
  const double speed_mps =
      (std::fabs(velocity_mps.x()) + std::fabs(velocity_mps.y())) + std::fabs(velocity_mps.z());
  const double a = (std::fabs(pull.x()) + std::fabs(pull.y())) + std::fabs(pull.z());
  const double rate =
      a == 0 ? 2 * speed_mps : speed_mps + std::sqrt(speed_mps * speed_mps + 2 * a * way_m);
  return rate > 0 ? ticks_after(2 * way_m / rate) : k_tick_max.value;
}

/// A span, or as much of it as a body may have one box for, which is its path's with a pad all
/// around. In a periodic world two bodies whose boxes overlap must be nearer to one another than to
/// other images, which Bodies::to_nearest_image counts on: their centres are apart by at most the
/// sum of both boxes' edges less both radii, and that is kept below half a period.
inline TickCount limited_span(const Bodies& bodies, BodyId body, Tick tick, TickCount span,
                              double pad_radii) {
  TickCount limited = std::min(span, k_tick_max - tick);
  if (!bodies.periodic()) return limited;
  const Flight& flight = bodies.flight(body);
  for (int i = 0; i < 3; ++i) {
    const double period = bodies.scene().period_m[static_cast<std::size_t>(i)];
    const double speed_mps = std::fabs(flight.velocity_mps[i]);
    if (period == 0 || speed_mps == 0) continue;
    // Of half a period each of the two has a half, less a hundredth of the period for roundings.
    const double way_m = 0.24 * period - (1 + 2 * pad_radii) * bodies.reach_m(body);
    limited = std::min(limited, ticks_before(way_m / speed_mps));
  }
  return std::max<TickCount>(1, limited);
}

/// The edge of most boxes.
inline double typical_box_m(const Bodies& bodies) {
  double sum_m = 0;
  for (BodyId body{}; body < bodies.size(); ++body)
    sum_m += 2 * bodies.constants(body).reach_m;
  return bodies.size() == 0 ? 1 : 1.3 * sum_m / static_cast<double>(bodies.size());
}

/// A body began a segment at this tick: it keeps its box if that holds it long enough.
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
  // The thesis doubles the time since the last box; here it changes by what that overlapped.
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
  // Some were looked at for as long as the last box held.
  for (StaticEdge& edge : statics_of(body)) {
    if (edge.prediction.certain || edge.prediction.tick > now_ + 1) continue;
    ++counts_.predictions;
    edge.prediction = predictions_.look_static(body, edge.index, now_, edge.search, bound.expiry);
  }
  sink.finish();
  refresh_key(body);
}

/// Makes the body's list that of the static features that it may meet in a box, by way of those in
/// a wider one. Whether the list changed.
template <BroadPhase Boxes, EventQueue Queue>
bool Engine<Boxes, Queue>::watch_statics(BodyId body, const Box& box) {
  if (!world_.statics().any() || world_.statics().count(body) == 0) return false;
  if (world_.replayed().has(body)) return false;
  if (!holds(static_boxes_[body], box)) {
    // A body that flies past would leave the wider box at once.
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
  // What was watched before keeps its prediction; both lists ascend.
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
  // Boxes last until the next event, but not too long: there may be no pair near for a while.
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
  // The event that came next may have been void; no box holds for longer than until it.
  if (queue_.least().key.tick > next && next < end) {
    queue_.set(slot_of(OwnSlot::new_boxes),
               {.tick = next, .kind = EventKind::update, .lower = k_nobody, .higher = k_nobody});
  }
}

/// Time that a body takes at least for a small part of its radius.
template <BroadPhase Boxes, EventQueue Queue>
TickCount Engine<Boxes, Queue>::least_span(BodyId body) const {
  return span_of_travel(bodies_, body, now_, k_least_box_radii);
}

}  // namespace sleight::physics
