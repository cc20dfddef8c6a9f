// Replays histories of another simulation.
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/physics/marbles/marbles.h"

namespace sleight::physics {
namespace {

/// Safety factor for the work limit. The work of replayed balls was counted in another simulation.
/// The work may differ here, because other balls disturb the balls that are left alone. So if the
/// total work times this factor exceeds the limit, the replay is void and everything is simulated.
constexpr std::uint64_t k_work_margin = 2;

}  // namespace

/// Let a ball have been left alone in its history. Returns whether it would get the same
/// confinement now.
bool Marbles::stays_alone(BodyId ball, const MarbleHistory::Part& part,
                          const MarbleHistory::Flight& way) const {
  const auto box = confinement_(
      {ball}, way.position_m,
      {.velocity_mps = way.velocity_mps, .angular_velocity_radps = way.angular_velocity_radps});
  if (!box) return false;
  const TouchBox confined = touch_box_of(*box);
  return confined.low_m == part.box.low_m && confined.high_m == part.box.high_m;
}

/// Returns the first tick, up to `until`, at which changes affect a ball's history. At this tick,
/// the ball meets a changed feature, has met a feature that has changed, or would not be left alone
/// in the same confinement. Returns k_never if there is none.
Tick Marbles::first_changed(BodyId ball, const MarbleReplay& replay, Tick until) {
  const MarbleHistory& history = *replayed_[ball];
  const auto is_changed = [&](FeatureId feature) {
    return feature != k_nothing && !is_changed_feature_.empty() &&
           is_changed_feature_[feature] != 0;
  };
  for (std::size_t i = 0; i < history.parts.size(); ++i) {
    const MarbleHistory::Part& part = history.parts[i];
    if (part.begin > until) break;
    if (is_changed(part.last_feature)) return part.begin;
    if (part.is_alone) {
      // A ball doesn't leave its confinement, whatever it meets there.
      if (replay.confinement_differs && !stays_alone(ball, part, history.flights[i]))
        return part.begin;
      continue;
    }
    Tick first = k_never;
    for (const MarbleChange& change : replay.changes) {
      if (!overlaps(change.box, part.box)) continue;
      // A ball's supports need no test, because the ball has met them before. If the ball starts
      // near a change, the start is tested again when it happens.
      const TouchBox start = way_box_of(history.flights[i].flight(), part.begin, part.begin);
      if (i == 0 && overlaps(change.box, start)) return part.begin;
      if (part.mode == MotionMode::resting) continue;
      const Tick end = i + 1 < history.parts.size() ? history.parts[i + 1].begin : until;
      first = std::min(
          first, first_met(history.flights[i].flight(), part.begin, std::min(end, end_), change));
    }
    if (first != k_never) return first;
  }
  return k_never;
}

void Marbles::begin_replay(const MarbleReplay& replay) {
  const std::size_t count = balls_.size();
  records_ = replay.records;
  met_.clear();
  replays_.clear();
  hastened_.clear();
  replayed_.assign(count, nullptr);
  last_event_.assign(count, Tick{});
  own_work_.assign(count, 0);
  since_checkpoint_.assign(count, 0);
  replayed_work_ = 0;
  lacks_checkpoint_ = false;
  if (records_) {
    kept_.resize(count);
    for (MarbleHistory& history : kept_)
      history.clear();
  }
  has_replayed_ = false;
  if (replay.histories == nullptr) return;
  CHECK_EQ(replay.histories->size(), count);
  for (BodyId ball{}; ball < count; ++ball) {
    if ((*replay.histories)[ball] == nullptr) continue;
    replayed_[ball] = (*replay.histories)[ball];
    replays_.push_back(ball);
  }
  has_replayed_ = !replays_.empty();
  part_now_.assign(count, 0);
  is_changed_feature_.assign(replay.changes.empty() ? 0 : statics_->feature_count(), 0);
  for (const MarbleChange& change : replay.changes) {
    for (const FeatureId feature : change.features)
      is_changed_feature_[feature] = 1;
  }
  for (const BodyId ball : replays_) {
    const MarbleHistory& history = *replayed_[ball];
    Tick until = history.stays ? k_never : history.until;
    if (!replay.changes.empty() || replay.confinement_differs)
      until = std::min(until, first_changed(ball, replay, until));
    for (const MarbleHistory::Meeting& meeting : history.meetings) {
      if (replayed_[meeting.partner] == nullptr) until = std::min(until, meeting.tick);
    }
    keys_[ball] = until == k_never
                      ? k_no_event
                      : EventKey{.tick = until, .kind = EventKind::update, .lower = ball};
  }
}

bool Marbles::is_replay_void() const {
  if (!has_replayed_) return false;
  if (failure_ || lacks_checkpoint_) return true;
  std::uint64_t work = counts_.work() + replayed_work_;
  for (const BodyId ball : replays_)
    work += replayed_[ball]->work;
  return work > work_max_ / k_work_margin;
}

void Marbles::stop_replay(BodyId marble) {
  if (replayed_[marble] == nullptr) return;
  goes_live(marble);
  // Use a key after all events of the present tick, because these events have happened.
  resume({.tick = now_, .kind = EventKind::sample, .lower = UINT32_MAX});
}

void Marbles::goes_live_by(BodyId ball, Tick tick) {
  if (replayed_[ball] == nullptr) return;
  if (tick <= present()) {
    goes_live(ball);
  } else if (tick < keys_[ball].tick) {
    keys_[ball] = {.tick = tick, .kind = EventKind::update, .lower = ball};
  }
}

/// Ends the replay of each ball in hastened_ from index `from` on. The replay ends at the ball's
/// tick, or now if this tick has come.
void Marbles::hasten(std::size_t from) {
  while (hastened_.size() > from) {
    const auto [ball, tick] = hastened_.back();
    hastened_.pop_back();
    goes_live_by(ball, tick);
  }
}

/// Simulates a ball from the present on. The ball first catches up.
void Marbles::goes_live(BodyId ball) {
  const std::shared_ptr<const MarbleHistory> history = std::move(replayed_[ball]);
  replayed_[ball] = nullptr;
  std::erase(replays_, ball);
  const Tick now = present();

  const std::size_t from = hastened_.size();
  hasten_partners(ball, now);
  bool is_gap = false;
  const MarbleHistory::Checkpoint* checkpoint = history->checkpoint_before(now, is_gap);
  if (is_gap) {
    lacks_checkpoint_ = true;
    fail(SceneError::Kind::incomplete_history,
         name(ball) + ": the body's history lacks a checkpoint");
  } else if (checkpoint == nullptr) {
    if (records_) begin_history(ball);
    keys_[ball] = {
        .tick = scene_->bodies[ball].start_tick, .kind = EventKind::start, .lower = ball};
  } else {
    go_on_from(ball, *history, *checkpoint, now);
    if (records_) keep_up_to(ball, *history, *checkpoint);
  }
  hasten(from);
}

/// The replay of `ball` ends. Collects the other balls whose replays must therefore end. They will
/// meet `ball`, rest on `ball`, or have just met it and may read it in rest decisions.
void Marbles::hasten_partners(BodyId ball, Tick now) {
  for (const BodyId other : replays_) {
    const MarbleHistory& theirs = *replayed_[other];
    bool has_met = false;
    for (const MarbleHistory::Meeting& meeting : theirs.meetings) {
      if (meeting.partner != ball) continue;
      if (meeting.tick >= now) {
        hastened_.emplace_back(other, meeting.tick);
      } else if (now - meeting.tick <= resting_.rest_span()) {
        hastened_.emplace_back(other, now);
      }
      has_met = has_met || meeting.tick < now;
    }
    if (!has_met) continue;
    bool is_gap = false;
    const MarbleHistory::Checkpoint* checkpoint = theirs.checkpoint_before(now, is_gap);
    if (is_gap || (checkpoint != nullptr && checkpoint->rest.rests_on(ball)))
      hastened_.emplace_back(other, now);
  }
}

/// Sets a ball to the state of a checkpoint, and queues the ball to catch up.
void Marbles::go_on_from(BodyId ball, const MarbleHistory& history,
                         const MarbleHistory::Checkpoint& checkpoint, Tick now) {
  // If the ball rests on other balls, these must be simulated, so that they can wake it.
  for (const BodyId other : replays_) {
    if (checkpoint.rest.rests_on(other)) hastened_.emplace_back(other, now);
  }
  balls_[ball] = checkpoint.marble;
  balls_[ball].suspended = balls_[ball].resumes = true;
  resting_.restore(ball, checkpoint.rest, history.touches);
  recent_.restore(ball, std::span(history.met).subspan(checkpoint.first_met, checkpoint.met_count));
  surroundings_[ball] = {};
  last_event_[ball] = checkpoint.tick;
  own_work_[ball] = checkpoint.work;
  since_checkpoint_[ball] = 0;
  replayed_work_ += checkpoint.work;
  keys_[ball] = k_no_event;
  to_resume_.push_back(ball);
}

/// Starts a ball's own history with a copy of the replayed history up to a checkpoint.
void Marbles::keep_up_to(BodyId ball, const MarbleHistory& history,
                         const MarbleHistory::Checkpoint& checkpoint) {
  MarbleHistory& own = kept_[ball];
  const auto is_before = [&](const auto& it) { return it.tick <= checkpoint.tick; };
  own.clear();
  const auto parts = static_cast<std::ptrdiff_t>(checkpoint.parts);
  own.parts.assign(history.parts.begin(), history.parts.begin() + parts);
  own.flights.assign(history.flights.begin(), history.flights.begin() + parts);
  std::ranges::copy_if(history.checkpoints, std::back_inserter(own.checkpoints), is_before);
  // Each checkpoint appends to the lists. So the data of later checkpoints come last, and are left
  // out.
  const std::size_t touches = checkpoint.rest.first_touch + checkpoint.rest.touch_count();
  const std::size_t met = checkpoint.first_met + checkpoint.met_count;
  own.touches.assign(history.touches.begin(),
                     history.touches.begin() + static_cast<std::ptrdiff_t>(touches));
  own.met.assign(history.met.begin(), history.met.begin() + static_cast<std::ptrdiff_t>(met));
  own.meetings.assign(history.meetings.begin(),
                      history.meetings.begin() + static_cast<std::ptrdiff_t>(checkpoint.meetings));
}

// ---- simulated and replayed balls ---------------------------------------------------------------

/// Finds replayed balls that ball `index` may meet up to the tick `to`. Ball `index` stays in the
/// box. If `is_path`, it follows its path in the box.
void Marbles::comes_near_replayed(BodyId index, const TouchBox& box, Tick to, bool is_path) {
  const Tick from = present();
  if (to < from) return;
  const double reach_m = 2 * (radius_m_ + k_place_pad_m);
  const std::size_t found = hastened_.size();
  for (const BodyId other : replays_) {
    const auto& parts = replayed_[other]->parts;
    find_part_now(other);
    for (auto part = parts.begin() + static_cast<std::ptrdiff_t>(part_now_[other]);
         part != parts.end() && part->begin <= to; ++part) {
      if (!overlaps(box, part->box) || apart_m2(box, part->box, radius_m_) > reach_m * reach_m)
        continue;
      const Tick begin = std::max(from, part->begin);
      const Tick end = part + 1 == parts.end() ? to : std::min(to, (part + 1)->begin);
      const auto number = static_cast<std::size_t>(part - parts.begin());
      if (!balls_[index].started || part->is_alone) {
        if (is_path && !path_meets(index, begin, end, part->box, 0)) continue;
        hastened_.emplace_back(other, begin);
        break;
      }
      const MarbleHistory::Flight& way = replayed_[other]->flights[number];
      const Tick tick = number == 0 && part->begin == begin && starts_at(index, way)
                            ? begin
                            : std::max(begin, meets_way(index, way, part->mode, begin, end));
      if (tick > end) continue;
      if (tick <= balls_[index].pair_tick) {
        balls_[index].pair_tick = tick;
        partners_[index] = other;
      }
      break;
    }
  }
  hasten(found);
}

/// Returns whether a replayed ball starts so near to `ball` that the two may overlap. `way` is the
/// replayed ball's first flight.
bool Marbles::starts_at(BodyId ball, const MarbleHistory::Flight& way) const {
  const double reach_m = 2 * (radius_m_ + k_place_pad_m);
  return apart_m2(path_box_of(ball, way.begin, way.begin),
                  way_box_of(way.flight(), way.begin, way.begin), radius_m_) <= reach_m * reach_m;
}

/// Returns the first tick from `from` to `until` at which a ball meets a ball with known motion.
/// The result may be too early, but never too late.
Tick Marbles::meets_way(BodyId ball, const MarbleHistory::Flight& way, MotionMode mode, Tick from,
                        Tick until) const {
  const Segment& segment = balls_[ball].segment;
  if (segment.mode == MotionMode::resting && mode == MotionMode::resting) return k_never;
  const double radii_m = radius_m_ + radius_m_;
  if (segment.mode == MotionMode::free && mode == MotionMode::free)
    return collision_of_flights(segment.flight, way.flight(), scene_->gravity_mps2, Vec3(0, 0, 0),
                                radii_m);
  return first_touch(segment.flight, way.flight(), from, until, {});
}

/// Advances part_now_ to the part of a replayed ball's path that is current at the present tick.
void Marbles::find_part_now(BodyId ball) {
  const auto& parts = replayed_[ball]->parts;
  std::size_t& part = part_now_[ball];
  while (part + 1 < parts.size() && parts[part + 1].begin <= present())
    ++part;
}

/// Returns the first tick at which a replayed ball comes near a box, according to its history, or
/// k_never.
Tick Marbles::replayed_comes_near(const TouchBox& box) {
  Tick first = k_never;
  for (const BodyId other : replays_) {
    const MarbleHistory& history = *replayed_[other];
    find_part_now(other);
    for (std::size_t i = part_now_[other]; i < history.parts.size(); ++i) {
      const Tick begin = std::max(now_, history.parts[i].begin);
      if (begin >= first) break;
      if (!overlaps(box, history.parts[i].box)) continue;
      const bool ends = i + 1 < history.parts.size() && !history.parts[i].is_alone;
      if (ends &&
          !way_meets(history.flights[i].flight(), begin, history.parts[i + 1].begin, box, 0))
        continue;
      first = begin;
    }
  }
  return first;
}

}  // namespace sleight::physics
