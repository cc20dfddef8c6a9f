#include "worker/worlds/user_scene/judge.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/math/elementary.h"

namespace sleight::worlds::user_scene {
namespace {

/// Times at which the gap of a missed hit is measured.
constexpr std::size_t k_gap_times = 100;

/// Returns the direction against gravity; +z without gravity.
Vec3 upward(const SceneDescription& description) {
  return physics::is_zero(description.gravity_mps2)
             ? Vec3(Vec3::UnitZ())
             : Vec3(-math::normalized(description.gravity_mps2));
}

}  // namespace

Judge::Judge(const SceneDescription& description, const BuiltScene& built,
             std::span<const Constraint> constraints)
    : built_(built),
      constraints_(constraints),
      end_s_(description.end_s),
      up_(upward(description)),
      owners_(built) {
  for (std::uint32_t object = 0; object < built.objects.size(); ++object)
    boxes_.push_back(built.objects[object].kind == ObjectKind::plane ? Region{}
                                                                     : box_of(built, object));
  for (const Constraint& one : constraints) {
    waits_for_rest_ = waits_for_rest_ || one.looks_at_rest();
    if (one.looks_at_hits()) {
      needs_recording_ = true;
      const double to_s = one.times_s.empty() ? one.to_s : one.times_s.back();
      last_s_ = std::max(last_s_, one.asks == Asks::never ? end_s_ : to_s + one.window_s);
    } else if (one.at_s) {
      times_s_.push_back(*one.at_s);
    }
  }
  std::ranges::sort(times_s_);
  times_s_.erase(std::unique(times_s_.begin(), times_s_.end()), times_s_.end());
  if (!times_s_.empty()) last_s_ = std::max(last_s_, times_s_.back());
  last_s_ = std::min(last_s_, end_s_);
  if (constraints.empty()) waits_for_rest_ = true;
  make_stages(description.has_noise());
}

double Judge::until_s(const Constraint& constraint) const {
  double until_s = std::numeric_limits<double>::infinity();
  if (constraint.asks == Asks::event) {
    until_s = (constraint.times_s.empty() ? constraint.to_s : constraint.times_s.back()) +
              constraint.window_s;
  } else if (constraint.asks == Asks::order) {
    until_s = 0;
    for (const std::uint32_t event : constraint.events)
      until_s = std::max(until_s, this->until_s(constraints_[event]));
  } else if (constraint.asks != Asks::never && constraint.asks != Asks::count && constraint.at_s) {
    until_s = *constraint.at_s;
  }
  return until_s < end_s_ ? until_s : std::numeric_limits<double>::infinity();
}

void Judge::make_stages(bool has_noise) {
  std::map<double, std::vector<std::uint32_t>> by_time;
  for (std::uint32_t i = 0; i < constraints_.size(); ++i)
    by_time[has_noise ? until_s(constraints_[i]) : last_s_].push_back(i);
  for (auto& [until_s, constraints] : by_time)
    stages_.push_back({until_s, std::move(constraints)});
  if (stages_.empty()) stages_.emplace_back();
  stages_.back().until_s = last_s_;
}

const BodyView& Judge::view(const Constraint& constraint, std::uint32_t body,
                            const Watched& watched) const {
  if (!constraint.at_s) return watched.at_end[body];
  const auto time = std::ranges::lower_bound(times_s_, *constraint.at_s);
  return watched.at_times[static_cast<std::size_t>(time - times_s_.begin())][body];
}

Judge::Measured Judge::of_body(const Constraint& constraint, std::uint32_t body,
                               const Watched& watched) const {
  const BodyView& seen = view(constraint, body, watched);
  if (!seen.takes_part) return {.distance = k_absent_z * constraint.sigma, .can_be_met = false};
  Measured measured{.distance = 0, .can_be_met = constraint.at_s || seen.rests};
  if (constraint.asks == Asks::region || constraint.asks == Asks::place) {
    measured.distance =
        constraint.whole
            ? outside_m(constraint.region, box_of(watched.scene.bodies[body].shape,
                                                  composed(seen.place, built_.objects[body].frame)))
            : outside_m(constraint.region, seen.place.position_m);
    return measured;
  }
  const Vec3 upright =
      constraint.asks == Asks::face
          ? constraint.axis
          : math::rotated(math::inverse(built_.objects[body].place.orientation), up_);
  const Vec3 axis = math::rotated(seen.place.orientation, upright);
  const double off_rad = math::atan2(math::norm(math::cross(axis, up_)), math::dot(axis, up_));
  measured.distance = constraint.asks == Asks::face      ? off_rad
                      : constraint.asks == Asks::topples ? std::max(0.0, k_topples_rad - off_rad)
                                                         : std::max(0.0, off_rad - k_stands_rad);
  return measured;
}

Judge::Measured Judge::of_count(const Constraint& constraint, const Watched& watched) const {
  std::uint32_t there = 0;
  for (const std::uint32_t body : constraint.bodies) {
    const BodyView& seen = view(constraint, body, watched);
    const bool counts = seen.takes_part && (constraint.at_s || seen.rests);
    if (counts && outside_m(constraint.region, seen.place.position_m) == 0) ++there;
  }
  return {.distance =
              static_cast<double>(constraint.at_least - std::min(there, constraint.at_least))};
}

Judge::HitTime Judge::hit_time(const Constraint& constraint, std::uint32_t body,
                               const Watched& watched) const {
  std::uint32_t hits = 0;
  for (const physics::Impact& impact : watched.impacts) {
    const std::uint32_t other = owners_.met_by(impact);
    const bool is_wanted =
        (impact.lower == body && std::ranges::count(constraint.hits, other) > 0) ||
        (other == body && std::ranges::count(constraint.hits, impact.lower) > 0);
    if (!is_wanted || impact.approach_mps < constraint.at_least_mps) continue;
    if (++hits == constraint.nth) return physics::seconds(impact.tick - physics::Tick{});
  }
  return std::nullopt;
}

double Judge::least_gap_m(const Constraint& constraint, std::uint32_t body, double from_s,
                          double to_s, const Watched& watched) const {
  const auto centre_m = [&](std::uint32_t one, physics::Tick tick) {
    const physics::Segment* segment = watched.recording->segment_at({one}, tick);
    return segment == nullptr ? watched.scene.bodies[one].start.pose.position_m
                              : physics::position_at(segment->flight, tick);
  };
  const auto reach_m = [&](std::uint32_t one) {
    return physics::reach_m(watched.scene.bodies[one].shape);
  };
  double least_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < k_gap_times; ++i) {
    const double share = static_cast<double>(i) / (k_gap_times - 1);
    const physics::Tick tick =
        std::min(physics::Tick{} + physics::ticks_after(from_s + share * (to_s - from_s)),
                 watched.recording->end());
    for (const std::uint32_t other : constraint.hits) {
      if (built_.objects[other].kind == ObjectKind::plane) {
        const physics::HalfSpace& plane = built_.scene.planes[built_.objects[other].first].outside;
        least_m = std::min(least_m, math::dot(plane.normal, centre_m(body, tick)) - plane.offset_m -
                                        reach_m(body));
        continue;
      }
      Region box = boxes_[other];
      if (other < built_.moving) {
        box.low_m = centre_m(other, tick) - Vec3::Constant(reach_m(other));
        box.high_m = centre_m(other, tick) + Vec3::Constant(reach_m(other));
      }
      least_m = std::min(least_m, outside_m(box, centre_m(body, tick)) - reach_m(body));
    }
  }
  return std::max(0.0, least_m);
}

Judge::Measured Judge::of_event(const Constraint& constraint, std::uint32_t body,
                                const Watched& watched, HitTime& time) const {
  time = hit_time(constraint, body, watched);
  if (constraint.asks == Asks::never) {
    if (!time) return {};
    return {.distance = end_s_ - *time, .can_be_met = false};
  }
  // The wanted time that is nearest to the hit, or the first one.
  double from_s = constraint.from_s;
  double to_s = std::min(constraint.to_s, end_s_);
  if (!constraint.times_s.empty()) {
    from_s = constraint.times_s.front();
    for (const double wanted_s : constraint.times_s) {
      if (time && std::fabs(wanted_s - *time) < std::fabs(from_s - *time)) from_s = wanted_s;
    }
    to_s = from_s;
  }
  if (time) {
    const double late_s = std::max({0.0, from_s - *time, *time - to_s});
    if (late_s <= constraint.window_s) return {.distance = late_s};
  }
  const double gap_m = least_gap_m(constraint, body, std::max(0.0, from_s - constraint.window_s),
                                   std::min(end_s_, to_s + constraint.window_s), watched);
  return {.distance = constraint.window_s + constraint.sigma * gap_m / constraint.near_m,
          .can_be_met = false};
}

Judge::Measured Judge::of_order(const Constraint& constraint,
                                std::span<const HitTime> hit_times) const {
  Measured measured;
  double before_s = 0;
  for (const std::uint32_t event : constraint.events) {
    measured.can_be_met = measured.can_be_met && hit_times[event];
    const double time_s = hit_times[event].value_or(end_s_);
    measured.distance = std::max(measured.distance, before_s - time_s);
    before_s = std::max(before_s, time_s);
  }
  return measured;
}

Judge::Measured Judge::of_constraint(const Constraint& constraint, const Watched& watched,
                                     std::span<const HitTime> hit_times, HitTime& time) const {
  if (constraint.asks == Asks::order) return of_order(constraint, hit_times);
  if (constraint.asks == Asks::count) return of_count(constraint, watched);
  Measured best{.distance = std::numeric_limits<double>::infinity(), .can_be_met = false};
  for (const std::uint32_t body : constraint.bodies) {
    HitTime hit;
    const Measured one = constraint.looks_at_hits() ? of_event(constraint, body, watched, hit)
                                                    : of_body(constraint, body, watched);
    const bool is_better =
        one.can_be_met == best.can_be_met ? one.distance < best.distance : one.can_be_met;
    if (!is_better) continue;
    best = one;
    time = hit;
  }
  return best;
}

Judgement Judge::judge(const Watched& watched, std::size_t stages) const {
  Judgement judgement;
  judgement.distances.assign(constraints_.size(), std::numeric_limits<double>::quiet_NaN());
  judgement.met.assign(constraints_.size(), false);
  std::vector<HitTime> hit_times(constraints_.size());
  // An order comes after its events in the request, and not in an earlier stage.
  for (std::size_t stage = 0; stage < stages; ++stage) {
    for (const std::uint32_t i : stages_[stage].constraints) {
      const Constraint& constraint = constraints_[i];
      const Measured measured = of_constraint(constraint, watched, hit_times, hit_times[i]);
      const bool is_met = measured.can_be_met && measured.distance <= constraint.tolerance;
      judgement.distances[i] = measured.distance;
      judgement.met[i] = is_met;
      judgement.all_met = judgement.all_met && is_met;
      judgement.log_constraint += log_constraint_of(constraint, measured.distance);
      const double decided_s = hit_times[i] ? *hit_times[i] : constraint.at_s.value_or(0);
      judgement.decided_s = std::max(judgement.decided_s, decided_s);
    }
  }
  return judgement;
}

}  // namespace sleight::worlds::user_scene
