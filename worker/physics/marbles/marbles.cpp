// The event loop of Marbles.
#include "worker/physics/marbles/marbles.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/check.h"

namespace sleight::physics {
bool are_marbles(const Scene& scene) {
  if (!scene.controls.empty() || scene.period_m != std::array<double, 3>{} || scene.filter.any() ||
      scene.noise.is_on())
    return false;
  if (!(scene.slow.separation_speed_mps > 0) || scene.bodies.empty()) return false;
  const BodyDescription& first = scene.bodies.front();
  const auto* ball = std::get_if<Sphere>(&first.shape);
  if (ball == nullptr) return false;
  return std::ranges::all_of(scene.bodies, [&](const BodyDescription& body) {
    const auto* sphere = std::get_if<Sphere>(&body.shape);
    return sphere != nullptr && sphere->radius_m == ball->radius_m &&
           body.material == first.material && body.inertia.mass_kg == first.inertia.mass_kg &&
           body.inertia.symmetry == InertiaSymmetry::spherical &&
           body.inertia.principal_kgm2 == first.inertia.principal_kgm2 && !body.start_again &&
           !body.fixed;
  });
}

void Marbles::start(const Scene& scene, const NearFeatures& near, Tick end,
                    MarbleConfinement confinement, std::uint64_t work_max,
                    const MarbleReplay& replay) {
  scene_ = &scene;
  near_ = &near;
  statics_ = &near.statics();
  confinement_ = std::move(confinement);
  end_ = end;
  now_ = Tick{};
  work_max_ = work_max;
  const BodyDescription& first = scene.bodies.front();
  radius_m_ = std::get<Sphere>(first.shape).radius_m;
  CHECK_EQ(radius_m_, near.radius_m());
  material_ = first.material;
  inertia_ = first.inertia;
  mass_ = sphere_mass(inertia_.mass_kg, radius_m_, inertia_.principal_kgm2.x());
  round_ = round_body(radius_m_, inertia_, scene.slow);
  const double pull_mps2 = math::norm(scene.gravity_mps2);
  contacts_last_ = statics_->feature_count() > 0;
  alone_for_ = contacts_last_ && pull_mps2 > 0
                   ? ticks_after(k_bounces_alone * 2 * scene.slow.separation_speed_mps / pull_mps2)
                   : 0;
  const double bounce_s = pull_mps2 > 0 ? 2 * scene.slow.separation_speed_mps / pull_mps2 : 1;
  const std::size_t count = scene.bodies.size();
  const std::vector<RestingBody> resting(
      count,
      {.weight_n = inertia_.mass_kg * scene.gravity_mps2, .reach_m = radius_m_, .round = true});
  resting_.reset(resting, scene.slow, ticks_after(k_jam_bounces * bounce_s));
  recent_.reset(count);
  balls_.assign(count, {});
  surroundings_.assign(count, {});
  boxes_.assign(count);
  keys_.resize(count);
  partners_.assign(count, k_none);
  for (BodyId ball{}; ball < count; ++ball) {
    keys_[ball] = {.tick = scene.bodies[ball].start_tick, .kind = EventKind::start, .lower = ball};
  }
  changed_.clear();
  to_resume_.clear();
  catches_up_ = false;
  counts_ = {};
  failure_.reset();
  begin_replay(replay);
}

std::optional<SceneError> Marbles::run_until(Tick tick) {
  CHECK_LE(tick.value, end_.value);
  if (tick < now_) return failure_;
  while (!failure_) {
    const EventKey event = *std::ranges::min_element(keys_);
    if (event.tick > tick) break;
    CHECK_GE(event.tick.value, now_.value);
    now_ = event.tick;
    process(event);
    if (!to_resume_.empty()) resume(event);
  }
  if (!failure_) now_ = tick;
  return failure_;
}

void Marbles::process(const EventKey& event) {
  const BodyId ball = event.body();
  if (counts_.work() > work_max_) {
    fail(SceneError::Kind::work_limit,
         fmt::format("{}: exceeded the limit of {} events at {:.9g} s", name(ball), work_max_,
                     seconds(event.tick - Tick{})));
    return;
  }
  if (event.kind != EventKind::update) {
    own_work_[ball] += event.kind == EventKind::rest ? k_rest_work : 1;
    last_event_[ball] = event.tick;
  }
  switch (event.kind) {
    case EventKind::start:
      start_ball(ball, event);
      return;
    case EventKind::collision:
      if (event.is_with_static()) {
        ++counts_.static_collisions;
        collide_static(ball, {event.met()}, event.tick);
      } else {
        ++counts_.collisions;
        collide(ball, event.other_body(), event.tick);
      }
      balls_changed();
      keep_checkpoints(ball);
      return;
    case EventKind::mode:
      ++counts_.modes;
      change_mode(ball, event.tick);
      balls_changed();
      keep_checkpoints(ball);
      return;
    case EventKind::rest:
      ++counts_.rest_decisions;
      if (rest(ball, event.tick) == 0) refresh_key(ball);
      balls_changed();
      keep_checkpoints(ball);
      return;
    case EventKind::update:
      if (replayed_[ball] != nullptr) {
        goes_live(ball);
      } else if (balls_[ball].suspended) {
        if (balls_[ball].resumes) return;
        balls_[ball].resumes = true;
        to_resume_.push_back(ball);
      } else {
        // Meanwhile the partner's replay may have ended for another reason.
        if (meets_replayed(ball)) goes_live(partners_[ball]);
        predict_pairs(ball);
        refresh_key(ball);
      }
      return;
    case EventKind::control:
    case EventKind::sample:
      break;
  }
  CHECK(false);
}

void Marbles::start_ball(BodyId ball, const EventKey& event) {
  const StartState& state = scene_->bodies[ball].start;
  balls_[ball].segment = {.flight = {.begin = event.tick,
                                     .position_m = state.pose.position_m,
                                     .velocity_mps = state.twist.velocity_mps,
                                     .acceleration_mps2 = scene_->gravity_mps2,
                                     .orientation = math::normalized(state.pose.orientation),
                                     .angular_velocity_radps = state.twist.angular_velocity_radps}};
  // If balls near the starting ball are left alone, they must catch up first.
  const TouchBox here = path_box_of(ball, event.tick, event.tick);
  if (!replays_.empty()) comes_near_replayed(ball, here, event.tick, false);
  boxes_.for_each_overlapping(here, [&](BodyId other) {
    if (!balls_[other].suspended || balls_[other].resumes) return;
    balls_[other].resumes = true;
    to_resume_.push_back(other);
  });
  if (!to_resume_.empty()) resume(event);
  const std::string obstacle = obstacle_of(ball);
  if (!obstacle.empty()) {
    fail(SceneError::Kind::overlap,
         fmt::format("{} can't start at {:.9g} s: it overlaps {}, or the gap is below {} m",
                     name(ball), seconds(event.tick - Tick{}), obstacle, k_touch_m));
    return;
  }
  balls_[ball].started = true;
  changed_.assign(1, ball);
  balls_changed();
  if (records_) {
    met_.assign(1, ball);
    keep_checkpoints(ball);
  }
}

/// Returns the name of an obstacle that a starting ball overlaps, or an empty string.
std::string Marbles::obstacle_of(BodyId ball) {
  const Vec3 place_m = place_at(ball, now_);
  for (BodyId other{}; other < balls_.size(); ++other) {
    if (!balls_[other].started || balls_[other].suspended) continue;
    const Vec3 between_m = ball < other ? Vec3(place_at(other, now_) - place_m)
                                        : Vec3(place_m - place_at(other, now_));
    if (touches(gap_of_spheres_m(between_m, radius_m_ + radius_m_))) return name(other);
  }
  const MovingPoint centre{.position_m = place_m,
                           .velocity_mps = balls_[ball].segment.flight.velocity_mps,
                           .acceleration_mps2 = scene_->gravity_mps2};
  FeatureId lowest = k_nothing;
  // Touch boxes are wider than the rounding of a position.
  const std::array<float, 4> rounded_m = floats_of(Four::of(place_m));
  const TouchBox here{.low_m = rounded_m, .high_m = rounded_m};
  const auto ask = [&](FeatureId index) {
    if (!overlaps(here, near_->touch_boxes()[index])) return;
    const SphereFeature& feature = statics_->feature(index);
    if (index < lowest && touches(gap_between(feature, centre, radius_m_).gap_m) &&
        is_inside(statics_->sides(feature), centre.position_m))
      lowest = index;
  };
  std::ranges::for_each(near_->everywhere(), ask);
  const NearFeatures::Cell cell = near_->cell_at(Four::of(place_m));
  std::ranges::for_each(cell.faces, ask);
  std::ranges::for_each(cell.corners, ask);
  if (lowest != k_nothing) return statics_->name_of_feature(lowest);
  // If a ball is deep inside a solid, it may not touch the solid's surface.
  const std::string* solid = statics_->solid_at(place_m);
  return solid != nullptr ? *solid : "";
}

/// Computes new predictions for the balls that began a segment at this event.
void Marbles::balls_changed() {
  const bool one = changed_.size() == 1;
  const auto count = size();
  const BodyId* const partners = partners_.data();
  if (one && suspend(changed_.front())) return;
  for (const BodyId ball : changed_) {
    balls_[ball].suspended = false;
    predict_static(ball);
  }
  for (const BodyId ball : changed_) {
    if (!one && suspend(ball)) continue;
    predict_pairs(ball);
    refresh_key(ball);
    for (BodyId other{}; other < count; ++other) {
      if (partners[other] != ball || std::ranges::binary_search(changed_, other)) continue;
      predict_pairs(other);
      refresh_key(other);
    }
  }
}

/// Called after a ball's motion has changed. If possible, leaves the ball alone; otherwise returns
/// false.
bool Marbles::suspend(BodyId ball) {
  if (!confinement_ || catches_up_ || is_resting(ball)) return false;
  // After two balls meet, rest decisions may still read both balls.
  if (resting_.enabled() && now_ - balls_[ball].supports.met_body <= resting_.rest_span())
    return false;
  const FreeFlight& flight = balls_[ball].segment.flight;
  const auto box = confinement_(ball, flight.position_m,
                                {.velocity_mps = flight.velocity_mps,
                                 .angular_velocity_radps = flight.angular_velocity_radps});
  if (!box) return false;
  const TouchBox confined = touch_box_of(*box);
  bool is_alone = true;
  boxes_.for_each_overlapping(confined, [&](BodyId other) {
    if (other == ball || !is_alone) return;
    is_alone = !balls_[other].suspended && !path_meets(other, now_, next_of(other), confined, 0);
  });
  if (!is_alone) return false;
  // The paths of replayed balls are known. So it is also known when one of them comes near the
  // confinement.
  const Tick disturbed = replayed_comes_near(confined);
  if (disturbed <= now_) return false;
  boxes_.set(ball, confined);
  Marble& left = balls_[ball];
  left.suspended = true;
  left.resumes = false;
  if (records_) keep_part(ball, confined);
  left.static_tick = left.pair_tick = k_never;
  left.static_feature = k_nothing;
  partners_[ball] = k_none;
  keys_[ball] = disturbed == k_never
                    ? k_no_event
                    : EventKey{.tick = disturbed, .kind = EventKind::update, .lower = ball};
  ++counts_.suspensions;
  for (BodyId other{}; other < balls_.size(); ++other) {
    if (partners_[other] != ball) continue;
    predict_pairs(other);
    refresh_key(other);
  }
  return true;
}

/// Lets the balls in to_resume_ catch up: processes all their events before the event `present`.
void Marbles::resume(const EventKey& present) {
  const Tick now = now_;
  // Calls may nest. If a ball starts during a call, other balls must catch up with this start.
  const bool outer = catches_up_;
  const Tick outer_present = present_;
  present_ = now;
  catches_up_ = true;
  while (!failure_) {
    if (!to_resume_.empty()) {
      const BodyId ball = to_resume_.back();
      to_resume_.pop_back();
      ++counts_.resumptions;
      balls_[ball].suspended = false;
      balls_[ball].resumes = false;
      now_ = balls_[ball].segment.flight.begin;
      changed_.assign(1, ball);
      balls_changed();
      continue;
    }
    const EventKey event = *std::ranges::min_element(keys_);
    if (!(event < present)) break;
    now_ = event.tick;
    process(event);
  }
  catches_up_ = outer;
  present_ = outer_present;
  now_ = now;
}

void Marbles::refresh_key(BodyId index) {
  const Marble& ball = balls_[index];
  EventKey best = k_no_event;
  const auto offer = [&](const EventKey& key) {
    if (key < best) best = key;
  };
  if (ball.static_tick <= best.tick && ball.static_feature != k_nothing)
    offer({.tick = ball.static_tick,
           .kind = EventKind::collision,
           .lower = index,
           .higher = k_static | ball.static_feature});
  const BodyId partner = partners_[index];
  if (partner != k_none && replayed_[partner] != nullptr) {
    // The partner's replay must end before the two balls meet.
    offer({.tick = ball.pair_tick, .kind = EventKind::update, .lower = index});
  } else if (partner != k_none) {
    offer({.tick = ball.pair_tick,
           .kind = EventKind::collision,
           .lower = std::min(index, partner),
           .higher = std::max(index, partner)});
  }
  if (ball.supports.end != k_never)
    offer({.tick = ball.supports.end, .kind = EventKind::mode, .lower = index});
  const Tick due = resting_.enabled() ? resting_.due(index) : k_never;
  if (due != k_never) offer({.tick = due, .kind = EventKind::rest, .lower = index});
  keys_[index] = best;
}

std::string Marbles::name(BodyId ball) const {
  const std::string& given = scene_->bodies[ball].name;
  return given.empty() ? fmt::format("body {}", ball) : fmt::format("body '{}'", given);
}

void Marbles::fail(SceneError::Kind kind, std::string message) {
  if (!failure_) failure_ = SceneError{kind, std::move(message)};
}

}  // namespace sleight::physics
