// How a simulation keeps its history, and how it replays that of another one (replay.h).
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {

// ---- keeping a history --------------------------------------------------------------------------

void World::begin_history(std::size_t bytes_max, bool records) {
  history_builder_ = std::make_unique<HistoryBuilder>(size(), bytes_max);
  records_without_history_ = records;
  record_ = false;  // the history has the segments
}

void World::append_to_history(const EventKey& event) {
  HistoryBuilder& builder = *history_builder_;
  builder.takes_part(event.lower);
  if (event.kind == EventKind::collision && (event.higher & k_static) == 0)
    builder.takes_part(event.higher);
  builder.finish(
      event, [&](Participant participant, std::vector<Segment>& segments,
                 std::vector<TouchRecord>& touches, std::vector<ContactState>& contact_states) {
        const std::uint32_t body = participant.body();
        if (participant.begins()) segments.push_back(segments_[body]);
        if (!participant.has_contact_state()) return;
        contact_states.push_back({.rest = resting_.state_of(body, touches),
                                  .supports = supports_.empty() ? Supports{} : supports_[body]});
      });
  if (builder.is_full()) stop_history();
}

void World::stop_history() {
  if (records_without_history_) {
    recording();
    record_ = true;
  } else {
    recording_.reset(size(), 0);
  }
  history_builder_ = nullptr;
}

Recording& World::recording() {
  if (history_builder_)
    history_recorded_ =
        append_to(recording_, history_builder_->writer().chunks(), history_recorded_);
  return recording_;
}

std::shared_ptr<const History> World::history(Tick now) {
  if (history_builder_ && history_builder_->is_full()) stop_history();
  if (!history_builder_ || failure_) return nullptr;
  return std::make_shared<const History>(History{.scene = scene_,
                                                 .chunks = history_builder_->writer().chunks(),
                                                 .end = std::min(now, k_tick_max - 1)});
}

// ---- replaying ----------------------------------------------------------------------------------

void World::begin_replay(std::shared_ptr<const History> history) {
  if (history == nullptr) return;
  SceneChanges changes = changes_between(history->scene, scene_, statics_);
  if (changes.laws) return;
  auto replay = std::make_unique<Replay>(std::move(history), std::move(changes));
  replay->awaited.assign(size(), 0);
  for (std::uint32_t body = 0; body < size(); ++body) {
    if (replay->changes.bodies[body] != 0 || scene_.bodies[body].start_tick > replay->history->end)
      continue;
    replay->awaited[body] = 1;
    ++replay->awaited_count;
  }
  if (replay->awaited_count == 0) return;
  replay_ = std::move(replay);
  replayed_.assign(size(), 0);
  find_quiet_until();
}

/// When a body's segment is the first to come near a place where static geometry differs, or a body
/// may start elsewhere because of that.
void World::find_quiet_until() {
  Replay& replay = *replay_;
  const ChangedPlaces& places = replay.changes.places;
  Tick until = std::min(replay.changes.first, replay.history->end + 1);
  std::vector<const Segment*> latest(places.none() ? 0 : size(), nullptr);
  const auto look = [&](std::uint32_t body, Tick end) {
    const Segment& segment = *latest[body];
    const Path path{.begin = segment.flight.begin,
                    .position_m = segment.flight.position_m,
                    .velocity_mps = segment.flight.velocity_mps,
                    .acceleration_mps2 = segment.flight.acceleration_mps2};
    if (places.meet(path_box(path, constants_[body].reach_m + k_touch_m, path.begin, end)))
      until = std::min(until, path.begin);
  };
  for (HistoryReader reader(replay.history->chunks);
       !places.none() && !reader.at_end() && reader.event().key.tick < until; reader.next()) {
    const HistoryEvent& event = reader.event();
    std::size_t segment = 0;
    for (const Participant& participant : event.participants) {
      if (!participant.begins()) continue;
      const std::uint32_t body = participant.body();
      if (latest[body] != nullptr) look(body, event.key.tick);
      latest[body] = &event.segments[segment++];
      if (event.key.kind != EventKind::start) continue;
      // It drew its place again, or would have to now.
      const Vec3& place_m = latest[body]->flight.position_m;
      if (place_m != scene_.bodies[body].start.pose.position_m || !solid_at(place_m).empty())
        until = std::min(until, event.key.tick);
    }
  }
  for (std::uint32_t body = 0; body < latest.size(); ++body) {
    if (latest[body] != nullptr && latest[body]->flight.begin < until) look(body, until);
  }
  replay.quiet_until = until;
}

/// Where a body touched a surface, at the beginning of the segment that it began then.
void World::restore_surface(const HistoryEvent& event) {
  const EventKey& key = event.key;
  const std::uint32_t index = key.higher & ~k_static;
  const auto touch = std::ranges::find_if(event.touches, [&](const TouchRecord& record) {
    return record.tick == key.tick && record.partner == k_static_partner && record.feature == index;
  });
  CHECK(touch != event.touches.end());
  std::size_t segment = 0;
  for (const Participant& participant : event.participants) {
    if (participant.begins() && participant.body() == key.lower)
      note_surface(key.lower, index, key.tick, event.segments[segment].flight.position_m,
                   touch->arm_m);
    if (participant.begins()) ++segment;
  }
}

/// What participants know after an event. REQUIRES: their segments have begun.
void World::restore(const HistoryEvent& event) {
  const EventKey& key = event.key;
  if (key.kind == EventKind::collision) {
    count_at(key.lower, key.tick);
    if ((key.higher & k_static) == 0) {
      count_at(key.higher, key.tick);
      recent_.note(key.lower, key.higher, key.tick, event.gap_m);
      if (!supports_.empty()) {
        supports_[key.lower].met_body = key.tick;
        supports_[key.higher].met_body = key.tick;
      }
    } else if (is_surface(key.lower, key.higher & ~k_static)) {
      restore_surface(event);
    } else if (!supports_.empty() && !constants_[key.lower].is_sphere) {
      supports_[key.lower].hits(key.higher & ~k_static, key.tick, alone_for_);
    }
  }
  std::size_t touch = 0;
  std::size_t kept = 0;
  for (const Participant& participant : event.participants) {
    const std::uint32_t body = participant.body();
    if (participant.touches()) resting_.touched(body, event.touches[touch++], participant.slowly());
    if (!participant.has_contact_state()) continue;
    const ContactState& known = event.contact_states[kept++];
    resting_.restore(body, known.rest, event.touches);
    touch += known.rest.touch_count();
    if (!supports_.empty()) supports_[body] = known.supports;
  }
}

Tick World::skip_quiet(Tick end) {
  Replay& replay = *replay_;
  HistoryReader& reader = replay.reader;
  const Tick last = std::min(end, replay.quiet_until - 1);
  std::vector<const Segment*> latest(size(), nullptr);
  std::size_t shared = 0;  ///< events that are the new history's already
  for (; !reader.at_end() && reader.event().key.tick <= last; reader.next()) {
    const HistoryEvent& event = reader.event();
    // All of the history so far is over by now.
    if (history_builder_ && shared == 0 && history_builder_->is_full()) stop_history();
    if (history_builder_ && shared == 0) {
      // Chunks that are skipped to their ends are shared.
      const auto chunk = reader.whole_chunk();
      if (chunk && chunk->event(chunk->size() - 1).key.tick <= last) {
        history_builder_->writer().share(chunk);
        shared = chunk->size();
      } else {
        history_builder_->writer().append(event);
        shared = 1;
      }
    }
    if (history_builder_) --shared;
    std::size_t segment = 0;
    for (const Participant& participant : event.participants) {
      if (!participant.begins()) continue;
      const std::uint32_t body = participant.body();
      latest[body] = &event.segments[segment++];
      if (!supports_.empty()) {
        supports_[body].count = 0;
        supports_[body].end = k_never;
      }
      if (record_) recording_.append({body}, *latest[body], event.key);
      if (event.key.kind == EventKind::start) set_replayed(body);
    }
    restore(event);
  }
  for (std::uint32_t body = 0; body < size(); ++body) {
    if (latest[body] == nullptr) continue;
    place(body, *latest[body]);
    started_[body] = 1;
  }
  return last;
}

/// A body's start was the history's.
void World::set_replayed(std::uint32_t body) {
  replay_->awaited[body] = 0;
  --replay_->awaited_count;
  replayed_[body] = 1;
  ++replayed_count_;
}

bool World::replays_start(std::uint32_t body, const EventKey& event) {
  if (!replay_ || replay_->awaited[body] == 0) return false;
  const HistoryEvent& next = replay_->reader.event();
  CHECK(next.key == event);
  const bool same = same_bits(next.segments[0], segments_[body]);
  replay_->reader.next();
  set_replayed(body);
  if (!same) {
    --replayed_count_;
    replayed_[body] = 0;
  }
  return same;
}

EventKey World::next_replayed() {
  HistoryReader& reader = replay_->reader;
  const auto concerns = [&](const Participant& participant) {
    return replayed_[participant.body()] != 0 || replay_->awaited[participant.body()] != 0;
  };
  while (!reader.at_end() && std::ranges::none_of(reader.event().participants, concerns))
    reader.next();
  if (!reader.at_end()) return reader.event().key;
  return {.tick = replay_->history->end + 1, .kind = EventKind::update};
}

bool World::play() {
  changed_.clear();
  Replay& replay = *replay_;
  if (replay.reader.at_end()) {
    for (std::uint32_t body = 0; body < size(); ++body)
      make_live(body);
    replay.awaited_count = 0;
    return false;
  }
  const HistoryEvent event = replay.reader.event();
  replay.reader.next();
  const bool is_changed_control =
      event.key.kind == EventKind::control && event.key.feature >= replay.changes.same_controls;
  const bool all = std::ranges::all_of(event.participants, [&](const Participant& participant) {
    return replayed_[participant.body()] != 0;
  });
  if (!all || is_changed_control) {
    for (const Participant& participant : event.participants)
      make_live(participant.body());
    return false;
  }
  if (history_builder_ && history_builder_->is_full()) stop_history();
  std::size_t segment = 0;
  for (const Participant& participant : event.participants) {
    if (!participant.begins()) continue;
    begin_segment(participant.body(), event.segments[segment++], event.key);
    changed_.push_back(participant.body());
  }
  std::ranges::sort(changed_);
  restore(event);
  if (history_builder_) history_builder_->replayed(event);
  return true;
}

void World::make_live(std::uint32_t body) {
  if (!is_replayed(body)) return;
  replayed_[body] = 0;
  --replayed_count_;
  gone_live_.push_back(body);
}

std::span<const std::uint32_t> World::bodies_gone_live() {
  // What they rest on as well: it must find them if it moves.
  for (std::size_t i = 0; i < gone_live_.size(); ++i) {
    const std::uint32_t body = gone_live_[i];
    if (!is_resting(body)) continue;
    resting_.for_each_supporter(body, [&](std::uint32_t other) { make_live(other); });
  }
  return gone_live_;
}

}  // namespace sleight::physics
