// What balls tell of themselves.
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/physics/marbles/marbles.h"

namespace sleight::physics {
namespace {

/// Marks of a ball, start included. Balls that lean on each other meet thousands of times, and a
/// simulation rarely goes on from there.
constexpr std::size_t k_marks_max = 48;

/// A ball that meets no other has a mark after so many events, since going on repeats all events
/// since the last mark; more marks cost more than they save. Of such marks it has at most
/// k_way_marks_max, which leaves room for those after meetings.
constexpr std::uint32_t k_mark_every = 16;
constexpr std::size_t k_way_marks_max = 24;

}  // namespace

void Marbles::begin_story(std::uint32_t ball) {
  told_[ball].clear();
  own_work_[ball] = 0;
  unmarked_[ball] = 0;
}

void Marbles::tell_part(std::uint32_t ball, const TouchBox& box) {
  auto& parts = told_[ball].parts;
  auto& ways = told_[ball].ways;
  const Marble& own = balls_[ball];
  // What was to come has not, or is told again. Of several collisions at a tick each counts.
  while (!parts.empty() &&
         (parts.back().begin > now_ ||
          (parts.back().begin == now_ && parts.back().last_feature == own.last_feature))) {
    parts.pop_back();
    ways.pop_back();
  }
  parts.push_back({.begin = now_,
                   .last_feature = own.last_feature,
                   .mode = own.segment.mode,
                   .is_alone = own.suspended,
                   .box = box});
  const FreeFlight& flight = own.segment.flight;
  ways.push_back({.begin = flight.begin,
                  .position_m = flight.position_m,
                  .velocity_mps = flight.velocity_mps,
                  .acceleration_mps2 = flight.acceleration_mps2,
                  .angular_velocity_radps = flight.angular_velocity_radps});
}

void Marbles::tell_meeting(std::uint32_t a, std::uint32_t b) {
  for (const auto& [ball, partner] : {std::pair(a, b), std::pair(b, a)}) {
    told_[ball].meetings.push_back({.tick = now_, .partner = partner});
    if (std::ranges::find(met_, ball) == met_.end()) met_.push_back(ball);
    last_event_[ball] = now_;
  }
}

/// What goes on from here, of which a part lies in the story's lists.
MarbleStory::Mark Marbles::mark_in(MarbleStory& story, std::uint32_t ball, Tick tick) const {
  MarbleStory::Mark mark{.tick = tick,
                         .parts = story.parts.size(),
                         .meetings = story.meetings.size(),
                         .work = own_work_[ball],
                         .marble = balls_[ball],
                         .rest = resting_.memory(ball, story.touches),
                         .first_met = story.met.size()};
  mark.met_count = recent_.remember(ball, story.met);
  return mark;
}

/// Of those that met at the event that has just been processed, and of its ball once in a while.
void Marbles::tell_marks(std::uint32_t of) {
  if (records_ && ++unmarked_[of] >= k_mark_every && told_[of].marks.size() < k_way_marks_max &&
      std::ranges::find(met_, of) == met_.end())
    met_.push_back(of);
  for (const std::uint32_t ball : met_) {
    MarbleStory& told = told_[ball];
    if (told.marks.size() == k_marks_max) {
      told.touches.resize(told.marks.back().rest.first_touch());
      told.met.resize(told.marks.back().first_met);
      told.marks.pop_back();
    }
    told.marks.push_back(mark_in(told, ball, now_));
    unmarked_[ball] = 0;
  }
  met_.clear();
}

MarbleStories Marbles::stories() const {
  CHECK(records_ && !is_replay_void());
  MarbleStories stories(balls_.size());
  for (std::uint32_t ball = 0; ball < balls_.size(); ++ball) {
    if (const auto& replayed = replayed_[ball]) {
      // Beyond the present it is another simulation's.
      if (replayed->stays && replayed->last.tick <= now_) stories[ball] = replayed;
      continue;
    }
    if (!balls_[ball].started) continue;
    auto story = std::make_shared<MarbleStory>();
    story->touches.reserve(told_[ball].touches.size() + Resting::k_records);
    story->met.reserve(told_[ball].met.size() + RecentContacts::k_partners);
    *story = told_[ball];
    story->last = mark_in(*story, ball, last_event_[ball]);
    story->work = own_work_[ball];
    story->until = now_;
    story->stays = balls_[ball].suspended || is_resting(ball);
    stories[ball] = std::move(story);
  }
  return stories;
}

}  // namespace sleight::physics
