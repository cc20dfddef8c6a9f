// Stores a world's data in histories, and restores the data.
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {

void World::append_to_history(const EventKey& event) {
  recorder_.keep(event,
                 [&](Participant participant, std::vector<Segment>& segments,
                     std::vector<TouchRecord>& touches, std::vector<ContactState>& contact_states) {
                   const BodyId body = participant.body();
                   if (participant.begins()) segments.push_back(bodies_.segment(body));
                   if (!participant.has_contact_state()) return;
                   contact_states.push_back(
                       {.rest = resting_.state_of(body, touches),
                        .supports = bodies_.may_stay() ? bodies_.supports_of(body) : Supports{}});
                 });
}

std::shared_ptr<const History> World::history(Tick now) {
  if (failure()) return nullptr;
  std::optional<HistoryChunks> chunks = recorder_.history();
  if (!chunks) return nullptr;
  return std::make_shared<const History>(History{
      .scene = scene(), .chunks = *std::move(chunks), .end = std::min(now, k_tick_max - 1)});
}

/// If a body touched a surface at an event, restores the place, using the segment that began at the
/// event.
void World::restore_surface(const HistoryEvent& event) {
  const EventKey& key = event.key;
  const StaticId met = key.met();
  const auto touch = std::ranges::find_if(event.touches, [&](const TouchRecord& record) {
    return record.tick == key.tick && record.partner == k_static_partner && record.feature == met;
  });
  CHECK(touch != event.touches.end());
  std::size_t segment = 0;
  for (const Participant& participant : event.participants) {
    if (participant.begins() && participant.body() == key.body())
      note_surface(key.body(), met, key.tick, event.segments[segment].flight.position_m,
                   touch->arm_m);
    if (participant.begins()) ++segment;
  }
}

void World::restore(const HistoryEvent& event) {
  const EventKey& key = event.key;
  if (key.kind == EventKind::collision) {
    const Impact impact{.tick = key.tick,
                        .lower = key.lower,
                        .higher = partner_of(key),
                        .noise_number = event.noise_number,
                        .approach_mps = event.approach_mps};
    if (keeps_impacts_) impacts_.push_back(impact);
    if (impact.noise_number > 0) noised(impact.lower, impact.higher) = impact.noise_number;
    count_at(key.body(), key.tick);
    if (!key.is_with_static()) {
      count_at(key.other_body(), key.tick);
      predictions_.have_collided(key.body(), key.other_body(), key.tick, event.gap_m);
      if (bodies_.may_stay()) {
        bodies_.supports_of(key.body()).met_body = key.tick;
        bodies_.supports_of(key.other_body()).met_body = key.tick;
      }
    } else if (statics_.is_surface(key.body(), key.met())) {
      restore_surface(event);
    } else if (bodies_.may_stay() && !bodies_.is_sphere(key.body())) {
      bodies_.supports_of(key.body()).hits(key.met(), key.tick, alone_for_);
    }
  }
  std::size_t touch = 0;
  std::size_t kept = 0;
  for (const Participant& participant : event.participants) {
    const BodyId body = participant.body();
    if (participant.touches()) resting_.touched(body, event.touches[touch++], participant.slowly());
    if (!participant.has_contact_state()) continue;
    const ContactState& known = event.contact_states[kept++];
    resting_.restore(body, known.rest, event.touches);
    touch += known.rest.touch_count();
    if (bodies_.may_stay()) bodies_.supports_of(body) = known.supports;
  }
}

void World::passes(const HistoryEvent& event) {
  std::size_t segment = 0;
  for (const Participant& participant : event.participants) {
    if (!participant.begins()) continue;
    const Segment& begun = event.segments[segment++];
    bodies_.stays_on_nothing(participant.body());
    recorder_.takes_over(participant.body(), begun, event.key);
  }
  restore(event);
}

void World::is_by_now(BodyId body, const Segment& segment) {
  place(body, segment);
  bodies_.has_started(body);
}

void World::happens_again(const HistoryEvent& event) {
  changed_.clear();
  recorder_.give_up_if_full();
  std::size_t segment = 0;
  for (const Participant& participant : event.participants) {
    if (!participant.begins()) continue;
    begin_segment(participant.body(), event.segments[segment++], event.key);
    changed_.push_back(participant.body());
  }
  std::ranges::sort(changed_);
  restore(event);
  recorder_.replayed(event);
}

}  // namespace sleight::physics
