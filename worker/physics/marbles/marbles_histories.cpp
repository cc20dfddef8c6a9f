// Stores the history of each ball.
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/marbles/marbles.h"

namespace sleight::physics {
namespace {

/// Maximum number of checkpoints per ball, including the start. Balls that lean on each other meet
/// thousands of times, but simulations rarely resume at such meetings. This constant and the next
/// two affect only speed.
constexpr std::size_t k_checkpoints_max = 48;

/// A ball that meets no other ball gets a checkpoint after this many events. Resuming repeats all
/// events since the last checkpoint, but more checkpoints cost more than they save.
/// k_lone_checkpoints_max leaves room for checkpoints after meetings.
constexpr std::uint32_t k_checkpoint_every = 16;
constexpr std::size_t k_lone_checkpoints_max = 24;

}  // namespace

void Marbles::begin_history(BodyId ball) {
  kept_[ball].clear();
  own_work_[ball] = 0;
  since_checkpoint_[ball] = 0;
}

void Marbles::keep_part(BodyId ball, const TouchBox& box) {
  auto& parts = kept_[ball].parts;
  auto& flights = kept_[ball].flights;
  const Marble& own = balls_[ball];
  // Remove parts of the path that begin in the future, and the part that is rewritten now. If a
  // ball collides several times at one tick, each collision has its own part.
  while (!parts.empty() &&
         (parts.back().begin > now_ ||
          (parts.back().begin == now_ && parts.back().last_feature == own.last_feature))) {
    parts.pop_back();
    flights.pop_back();
  }
  parts.push_back({.begin = now_,
                   .last_feature = own.last_feature,
                   .mode = own.segment.mode,
                   .is_alone = own.suspended,
                   .box = box});
  const FreeFlight& flight = own.segment.flight;
  flights.push_back({.begin = flight.begin,
                     .position_m = flight.position_m,
                     .velocity_mps = flight.velocity_mps,
                     .acceleration_mps2 = flight.acceleration_mps2,
                     .angular_velocity_radps = flight.angular_velocity_radps});
}

void Marbles::keep_meeting(BodyId a, BodyId b) {
  for (const auto& [ball, partner] : {std::pair(a, b), std::pair(b, a)}) {
    kept_[ball].meetings.push_back({.tick = now_, .partner = partner});
    if (std::ranges::find(met_, ball) == met_.end()) met_.push_back(ball);
    last_event_[ball] = now_;
  }
}

/// Creates a checkpoint of a ball's current state. Appends some of its data to the history's lists.
MarbleHistory::Checkpoint Marbles::checkpoint_in(MarbleHistory& history, BodyId ball,
                                                 Tick tick) const {
  MarbleHistory::Checkpoint checkpoint{.tick = tick,
                                       .parts = history.parts.size(),
                                       .meetings = history.meetings.size(),
                                       .work = own_work_[ball],
                                       .marble = balls_[ball],
                                       .rest = resting_.state_of(ball, history.touches),
                                       .first_met = history.met.size()};
  checkpoint.met_count = recent_.remember(ball, history.met);
  return checkpoint;
}

/// Adds checkpoints for the balls that met at this event, and sometimes for the event's own ball.
void Marbles::keep_checkpoints(BodyId of) {
  if (records_ && ++since_checkpoint_[of] >= k_checkpoint_every &&
      kept_[of].checkpoints.size() < k_lone_checkpoints_max &&
      std::ranges::find(met_, of) == met_.end())
    met_.push_back(of);
  for (const BodyId ball : met_) {
    MarbleHistory& kept = kept_[ball];
    if (kept.checkpoints.size() == k_checkpoints_max) {
      kept.touches.resize(kept.checkpoints.back().rest.first_touch);
      kept.met.resize(kept.checkpoints.back().first_met);
      kept.checkpoints.pop_back();
    }
    kept.checkpoints.push_back(checkpoint_in(kept, ball, now_));
    since_checkpoint_[ball] = 0;
  }
  met_.clear();
}

MarbleHistories Marbles::histories() const {
  CHECK(records_ && !is_replay_void());
  MarbleHistories histories(balls_.size());
  for (BodyId ball{}; ball < balls_.size(); ++ball) {
    if (const auto& replayed = replayed_[ball]) {
      // Use the replayed history only if it doesn't extend beyond the present.
      if (replayed->stays && replayed->last.tick <= now_) histories[ball] = replayed;
      continue;
    }
    if (!balls_[ball].started) continue;
    auto history = std::make_shared<MarbleHistory>();
    history->touches.reserve(kept_[ball].touches.size() + 2 * k_touch_records_max);
    history->met.reserve(kept_[ball].met.size() + RecentContacts::k_partners);
    *history = kept_[ball];
    history->last = checkpoint_in(*history, ball, last_event_[ball]);
    history->work = own_work_[ball];
    history->until = now_;
    history->stays = balls_[ball].suspended || is_resting(ball);
    histories[ball] = std::move(history);
  }
  return histories;
}

}  // namespace sleight::physics
