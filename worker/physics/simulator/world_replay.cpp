// What a simulation tells of itself, and how it goes through what another one told (replay.h).
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {

// ---- telling ------------------------------------------------------------------------------------

void World::begin_telling(std::size_t bytes_max, bool records) {
  telling_ = std::make_unique<Telling>(size(), bytes_max);
  records_without_telling_ = records;
  record_ = false;  // the history has the segments
}

void World::tell_event(const EventKey& event) {
  Telling& telling = *telling_;
  telling.takes_part(event.lower);
  if (event.kind == EventKind::collision && (event.higher & k_static) == 0)
    telling.takes_part(event.higher);
  telling.finish(event, [&](Participant participant, std::vector<Segment>& segments,
                            std::vector<TouchRecord>& touches, std::vector<BodyMemory>& memories) {
    const std::uint32_t body = participant.body();
    if (participant.begins()) segments.push_back(segments_[body]);
    if (!participant.remembers()) return;
    memories.push_back({.rest = resting_.memory(body, touches),
                        .supports = supports_.empty() ? Supports{} : supports_[body]});
  });
  if (telling.is_full()) stop_telling();
}

void World::stop_telling() {
  if (records_without_telling_) {
    recording();
    record_ = true;
  } else {
    recording_.reset(size(), 0);
  }
  telling_ = nullptr;
}

Recording& World::recording() {
  if (telling_) told_recorded_ = append_to(recording_, telling_->writer().chunks(), told_recorded_);
  return recording_;
}

std::shared_ptr<const History> World::history(Tick now) {
  if (telling_ && telling_->is_full()) stop_telling();
  if (!telling_ || failure_) return nullptr;
  return std::make_shared<const History>(History{.scene = scene_,
                                                 .chunks = telling_->writer().chunks(),
                                                 .end = std::min(now, k_tick_max - 1)});
}

// ---- replaying ----------------------------------------------------------------------------------

void World::begin_replay(std::shared_ptr<const History> past) {
  if (past == nullptr) return;
  SceneChanges changes = changes_between(past->scene, scene_, statics_);
  if (changes.laws) return;
  auto replay = std::make_unique<Replay>(std::move(past), std::move(changes));
  replay->awaited.assign(size(), 0);
  for (std::uint32_t body = 0; body < size(); ++body) {
    if (replay->changes.bodies[body] != 0 || scene_.bodies[body].start_tick > replay->past->end)
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
  Tick until = std::min(replay.changes.first, replay.past->end + 1);
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
  for (HistoryReader reader(replay.past->chunks);
       !places.none() && !reader.at_end() && reader.event().key.tick < until; reader.next()) {
    const ToldEvent& event = reader.event();
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
void World::recall_surface(const ToldEvent& event) {
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
void World::recall(const ToldEvent& event) {
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
      recall_surface(event);
    }
  }
  std::size_t touch = 0;
  std::size_t memory = 0;
  for (const Participant& participant : event.participants) {
    const std::uint32_t body = participant.body();
    if (participant.touches()) resting_.touched(body, event.touches[touch++], participant.slowly());
    if (!participant.remembers()) continue;
    const BodyMemory& known = event.memories[memory++];
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
    const ToldEvent& event = reader.event();
    // All that was told is over by now.
    if (telling_ && shared == 0 && telling_->is_full()) stop_telling();
    if (telling_ && shared == 0) {
      // Chunks that are skipped to their ends are shared.
      const auto chunk = reader.whole_chunk();
      if (chunk && chunk->event(chunk->size() - 1).key.tick <= last) {
        telling_->writer().share(chunk);
        shared = chunk->size();
      } else {
        telling_->writer().append(event);
        shared = 1;
      }
    }
    if (telling_) --shared;
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
    recall(event);
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
  const ToldEvent& told = replay_->reader.event();
  CHECK(told.key == event);
  const bool same = same_bits(told.segments[0], segments_[body]);
  replay_->reader.next();
  set_replayed(body);
  if (!same) {
    --replayed_count_;
    replayed_[body] = 0;
  }
  return same;
}

EventKey World::next_told() {
  HistoryReader& reader = replay_->reader;
  const auto concerns = [&](const Participant& participant) {
    return replayed_[participant.body()] != 0 || replay_->awaited[participant.body()] != 0;
  };
  while (!reader.at_end() && std::ranges::none_of(reader.event().participants, concerns))
    reader.next();
  if (!reader.at_end()) return reader.event().key;
  return {.tick = replay_->past->end + 1, .kind = EventKind::update};
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
  const ToldEvent event = replay.reader.event();
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
  if (telling_ && telling_->is_full()) stop_telling();
  std::size_t segment = 0;
  for (const Participant& participant : event.participants) {
    if (!participant.begins()) continue;
    begin_segment(participant.body(), event.segments[segment++], event.key);
    changed_.push_back(participant.body());
  }
  std::ranges::sort(changed_);
  recall(event);
  if (telling_) telling_->replayed(event);
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
