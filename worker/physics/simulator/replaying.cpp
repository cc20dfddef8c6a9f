#include "worker/physics/simulator/replaying.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/physics/scene/same_bits.h"

namespace sleight::physics {

Replaying::Replaying(World& world, std::shared_ptr<const History> history) : world_(world) {
  if (history == nullptr) return;
  SceneChanges changes =
      changes_between(history->scene, world.bodies().scene(), world.statics().geometry());
  if (changes.laws) return;
  auto replay = std::make_unique<Replay>(std::move(history), std::move(changes));
  replay->awaited.assign(world_.bodies().size(), 0);
  for (BodyId body{}; body < world_.bodies().size(); ++body) {
    if (replay->changes.bodies[body] != 0 ||
        world_.bodies().scene().bodies[body].start_tick > replay->history->end)
      continue;
    replay->awaited[body] = 1;
    ++replay->awaited_count;
  }
  if (replay->awaited_count == 0) return;
  replay_ = std::move(replay);
  find_quiet_until();
}

bool Replaying::has_other_noise(const HistoryEvent& event) const {
  if (event.noise_number == 0) return false;
  const NoiseValues* was = replay_->history->scene.noise.values.get();
  const NoiseValues* is = world_.bodies().scene().noise.values.get();
  if (was == is) return false;
  const NoiseAddress address{event.key.lower, world_.partner_of(event.key), event.noise_number};
  return !std::ranges::equal(was->at(address), is->at(address),
                             [](double a, double b) { return same(a, b); });
}

/// Finds the tick until which only the history's events happen. From this tick on, a segment may
/// come near changed static geometry, or a body may start elsewhere because of the change.
void Replaying::find_quiet_until() {
  Replay& replay = *replay_;
  const ChangedPlaces& places = replay.changes.places;
  Tick until = std::min(replay.changes.first, replay.history->end + 1);
  const bool noised = replay.history->scene.noise.is_on();
  std::vector<const Segment*> latest(places.none() ? 0 : bodies().size(), nullptr);
  const auto look = [&](BodyId body, Tick end) {
    const Segment& segment = *latest[body];
    const Path path{.begin = segment.flight.begin,
                    .position_m = segment.flight.position_m,
                    .velocity_mps = segment.flight.velocity_mps,
                    .acceleration_mps2 = segment.flight.acceleration_mps2};
    if (places.meet(path_box(path, bodies().constants(body).reach_m + k_touch_m, path.begin, end)))
      until = std::min(until, path.begin);
  };
  for (HistoryReader reader(replay.history->chunks);
       (noised || !places.none()) && !reader.at_end() && reader.event().key.tick < until;
       reader.next()) {
    const HistoryEvent& event = reader.event();
    if (noised && has_other_noise(event)) until = event.key.tick;
    if (places.none()) continue;
    std::size_t segment = 0;
    for (const Participant& participant : event.participants) {
      if (!participant.begins()) continue;
      const BodyId body = participant.body();
      if (latest[body] != nullptr) look(body, event.key.tick);
      const Segment& begun = event.segments[segment++];
      if (bodies().is_fixed(body)) continue;  // meets no static geometry
      latest[body] = &begun;
      if (event.key.kind != EventKind::start) continue;
      // Test whether the body used `start_again` in the history, or must use it now.
      const Vec3& place_m = latest[body]->flight.position_m;
      if (place_m != bodies().scene().bodies[body].start.pose.position_m ||
          !world_.statics().solid_at(body, place_m).empty())
        until = std::min(until, event.key.tick);
    }
  }
  for (BodyId body{}; body < latest.size(); ++body) {
    if (latest[body] != nullptr && latest[body]->flight.begin < until) look(body, until);
  }
  replay.quiet_until = until;
}

Tick Replaying::skip_quiet(Tick end) {
  Replay& replay = *replay_;
  HistoryReader& reader = replay.reader;
  const Tick last = std::min(end, replay.quiet_until - 1);
  std::vector<const Segment*> latest(bodies().size(), nullptr);
  for (; !reader.at_end() && reader.event().key.tick <= last; reader.next()) {
    const HistoryEvent& event = reader.event();
    world_.recorder().takes_over(reader, last);
    world_.passes(event);
    std::size_t segment = 0;
    for (const Participant& participant : event.participants) {
      if (!participant.begins()) continue;
      const BodyId body = participant.body();
      latest[body] = &event.segments[segment++];
      if (event.key.kind != EventKind::start) continue;
      replay.awaited[body] = 0;
      --replay.awaited_count;
      world_.replayed().add(body, bodies().is_fixed(body));
    }
  }
  for (BodyId body{}; body < bodies().size(); ++body) {
    if (latest[body] == nullptr) continue;
    world_.is_by_now(body, *latest[body]);
  }
  return last;
}

bool Replaying::begins_as(BodyId body, const HistoryEvent& start) {
  if (!same_bits(start.segments[0], bodies().segment(body))) return false;
  if (start.contact_states.empty()) return true;
  // The body starts at rest: its contacts and supporters depend on its whole structure.
  const RestState& was = start.contact_states[0].rest;
  std::vector<TouchRecord> touches;
  const RestState is = world_.resting().state_of(body, touches);
  const auto supporters = [](const RestState& state) {
    return std::span(state.supporters).first(state.supporter_count);
  };
  return was.count == is.count && was.held_count == is.held_count &&
         std::ranges::equal(supporters(was), supporters(is)) &&
         std::ranges::equal(start.touches, touches, [](const TouchRecord& a, const TouchRecord& b) {
           return same_bits(a, b);
         });
}

bool Replaying::starts(BodyId body, const EventKey& event) {
  const auto stop_waiting = [&](BodyId one) {
    if (replay_->awaited[one] == 0) return;
    replay_->awaited[one] = 0;
    --replay_->awaited_count;
  };
  bool same = false;
  if (replay_->awaited[body] != 0) {
    const HistoryEvent& next = replay_->reader.event();
    CHECK(next.key == event);
    same = begins_as(body, next);
    replay_->reader.next();
    stop_waiting(body);
  }
  if (same) {
    world_.replayed().add(body, bodies().is_fixed(body));
  } else if (bodies().is_resting(body) && !bodies().is_fixed(body)) {
    // A moving supporter must wake the body.
    for (const BodyId supporter : world_.resting().supporters(body)) {
      world_.replayed().make_live(supporter);
      stop_waiting(supporter);
    }
  }
  return same;
}

EventKey Replaying::next() {
  HistoryReader& reader = replay_->reader;
  const auto concerns = [&](const Participant& participant) {
    const BodyId body = participant.body();
    return (world_.replayed().has(body) && !bodies().is_fixed(body)) || replay_->awaited[body] != 0;
  };
  while (!reader.at_end() && std::ranges::none_of(reader.event().participants, concerns))
    reader.next();
  if (!reader.at_end()) return reader.event().key;
  return {.tick = replay_->history->end + 1, .kind = EventKind::update};
}

bool Replaying::play() {
  world_.nothing_changed();
  Replay& replay = *replay_;
  if (replay.reader.at_end()) {
    for (BodyId body{}; body < bodies().size(); ++body)
      world_.replayed().make_live(body);
    replay.awaited_count = 0;
    return false;
  }
  const HistoryEvent event = replay.reader.event();
  replay.reader.next();
  const bool is_changed_control =
      event.key.kind == EventKind::control && event.key.feature >= replay.changes.same_controls;
  const bool all = std::ranges::all_of(event.participants, [&](const Participant& participant) {
    return world_.replayed().has(participant.body());
  });
  if (!all || is_changed_control || has_other_noise(event)) {
    for (const Participant& participant : event.participants)
      world_.replayed().make_live(participant.body());
    return false;
  }
  world_.happens_again(event);
  return true;
}

std::span<const BodyId> Replaying::make_supporters_live() {
  // Iterate by index, because the list grows in the loop.
  ReplayedBodies& replayed = world_.replayed();
  for (std::size_t i = 0; i < replayed.gone_live().size(); ++i) {
    const BodyId body = replayed.gone_live()[i];
    if (!bodies().is_resting(body)) continue;
    for (const BodyId other : world_.resting().supporters(body))
      replayed.make_live(other);
  }
  return replayed.gone_live();
}

}  // namespace sleight::physics
