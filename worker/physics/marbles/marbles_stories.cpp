// What balls tell of themselves, and how others' stories are replayed.
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/physics/marbles/marbles.h"

namespace sleight::physics {
namespace {

/// Of a ball, start included. Balls that lean on each other meet thousands of times; who goes on
/// from there is rare.
constexpr std::size_t k_marks_max = 48;

/// The work of what is replayed was counted in another simulation, in which others disturbed balls
/// that were left alone. So one that comes within this factor of the work that it may take is void.
constexpr std::uint64_t k_work_margin = 2;

/// When a ball that is told of is in one of some boxes, from a tick on; k_never if never.
Tick first_in(const MarbleStory& story, std::span<const TouchBox> boxes, Tick from) {
  if (boxes.empty() || from == k_never) return k_never;
  for (std::size_t i = 0; i < story.parts.size(); ++i) {
    const bool is_over = i + 1 < story.parts.size() && story.parts[i + 1].begin < from;
    if (is_over) continue;
    const auto& part = story.parts[i];
    if (std::ranges::any_of(boxes, [&](const TouchBox& box) { return overlaps(box, part.box); }))
      return std::max(from, part.begin);
  }
  return k_never;
}

}  // namespace

// ---- telling ------------------------------------------------------------------------------------

void Marbles::begin_story(std::uint32_t ball) {
  told_[ball].clear();
  own_work_[ball] = 0;
}

void Marbles::tell_part(std::uint32_t ball, const TouchBox& box) {
  auto& parts = told_[ball].parts;
  // What was to come has not, or is told again.
  while (!parts.empty() && parts.back().begin >= now_)
    parts.pop_back();
  parts.push_back({.begin = now_, .is_alone = balls_[ball].suspended, .box = box});
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
                         .work = own_work_[ball],
                         .marble = balls_[ball],
                         .rest = resting_.memory(ball, story.touches),
                         .first_met = story.met.size()};
  mark.met_count = recent_.remember(ball, story.met);
  return mark;
}

/// Of those that met at the event that has just been processed.
void Marbles::tell_marks() {
  for (const std::uint32_t ball : met_) {
    MarbleStory& told = told_[ball];
    if (told.marks.size() == k_marks_max) {
      told.touches.resize(told.marks.back().rest.first_touch());
      told.met.resize(told.marks.back().first_met);
      told.marks.pop_back();
    }
    told.marks.push_back(mark_in(told, ball, now_));
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

// ---- replaying ----------------------------------------------------------------------------------

void Marbles::begin_replay(const MarbleReplay& replay) {
  const std::size_t count = balls_.size();
  records_ = replay.records;
  met_.clear();
  replays_.clear();
  hastened_.clear();
  replayed_.assign(count, nullptr);
  last_event_.assign(count, Tick{});
  own_work_.assign(count, 0);
  replayed_work_ = 0;
  lacks_mark_ = false;
  if (records_) {
    told_.resize(count);
    for (MarbleStory& story : told_)
      story.clear();
  }
  has_replayed_ = false;
  if (replay.stories == nullptr) return;
  CHECK_EQ(replay.stories->size(), count);
  for (std::uint32_t ball = 0; ball < count; ++ball) {
    if ((*replay.stories)[ball] == nullptr) continue;
    replayed_[ball] = (*replay.stories)[ball];
    replays_.push_back(ball);
  }
  has_replayed_ = !replays_.empty();
  for (const std::uint32_t ball : replays_) {
    const MarbleStory& story = *replayed_[ball];
    Tick until = story.stays ? k_never : story.until;
    until = std::min({until, first_in(story, replay.changed, Tick{}),
                      first_in(story, replay.changed_confinements, story.alone_from)});
    for (const MarbleStory::Meeting& meeting : story.meetings) {
      if (replayed_[meeting.partner] == nullptr) until = std::min(until, meeting.tick);
    }
    keys_[ball] = until == k_never
                      ? k_no_event
                      : EventKey{.tick = until, .kind = EventKind::update, .lower = ball};
  }
}

bool Marbles::is_replay_void() const {
  if (!has_replayed_) return false;
  if (failure_ || lacks_mark_) return true;
  std::uint64_t work = counts_.work() + replayed_work_;
  for (const std::uint32_t ball : replays_)
    work += replayed_[ball]->work;
  return work > work_max_ / k_work_margin;
}

void Marbles::stop_replay(BodyId marble) {
  if (replayed_[marble.value] == nullptr) return;
  goes_live(marble.value);
  // All that happens up to the present has happened.
  resume({.tick = now_, .kind = EventKind::sample, .lower = UINT32_MAX});
}

void Marbles::goes_live_by(std::uint32_t ball, Tick tick) {
  if (replayed_[ball] == nullptr) return;
  if (tick <= present()) {
    goes_live(ball);
  } else if (tick < keys_[ball].tick) {
    keys_[ball] = {.tick = tick, .kind = EventKind::update, .lower = ball};
  }
}

/// Makes all of them that were found since the list was so long go live.
void Marbles::hasten(std::size_t from) {
  while (hastened_.size() > from) {
    const auto [ball, tick] = hastened_.back();
    hastened_.pop_back();
    goes_live_by(ball, tick);
  }
}

/// From the present on a ball is simulated. It is then among those that catch up.
void Marbles::goes_live(std::uint32_t ball) {
  const std::shared_ptr<const MarbleStory> story = std::move(replayed_[ball]);
  replayed_[ball] = nullptr;
  std::erase(replays_, ball);
  const Tick now = present();

  // What it did to others in its story it may not do now: neither meet them, nor be what the one
  // that it has just met rests on, or asks about rest with.
  const std::size_t from = hastened_.size();
  for (const std::uint32_t other : replays_) {
    const MarbleStory& theirs = *replayed_[other];
    bool has_met = false;
    for (const MarbleStory::Meeting& meeting : theirs.meetings) {
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
    const MarbleStory::Mark* mark = theirs.mark_before(now, is_gap);
    if (is_gap || (mark != nullptr && mark->rest.rests_on(ball)))
      hastened_.emplace_back(other, now);
  }

  bool is_gap = false;
  const MarbleStory::Mark* mark = story->mark_before(now, is_gap);
  if (is_gap) {
    lacks_mark_ = true;
    fail(SceneError::Kind::search_failed, name(ball) + ": its story lacks a mark");
  } else if (mark == nullptr) {
    if (records_) begin_story(ball);
    keys_[ball] = {
        .tick = scene_->bodies[ball].start_tick, .kind = EventKind::start, .lower = ball};
  } else {
    // What it rests on must be there to wake it.
    for (const std::uint32_t other : replays_) {
      if (mark->rest.rests_on(other)) hastened_.emplace_back(other, now);
    }
    balls_[ball] = mark->marble;
    balls_[ball].suspended = balls_[ball].resumes = true;  // waits to catch up
    resting_.restore(ball, mark->rest, story->touches);
    recent_.restore(ball, std::span(story->met).subspan(mark->first_met, mark->met_count));
    surroundings_[ball] = {};
    last_event_[ball] = mark->tick;
    own_work_[ball] = mark->work;
    replayed_work_ += mark->work;
    keys_[ball] = k_no_event;
    to_resume_.push_back(ball);
    if (records_) {
      MarbleStory& own = told_[ball];
      const auto is_before = [&](const auto& it) { return it.tick <= mark->tick; };
      own.clear();
      if (story->alone_from <= mark->tick) own.alone_from = story->alone_from;
      own.parts.assign(story->parts.begin(),
                       story->parts.begin() + static_cast<std::ptrdiff_t>(mark->parts));
      std::ranges::copy_if(story->marks, std::back_inserter(own.marks), is_before);
      // Lists grow with marks, so what later ones know lies behind.
      const std::size_t touches = mark->rest.first_touch() + mark->rest.touch_count();
      const std::size_t met = mark->first_met + mark->met_count;
      own.touches.assign(story->touches.begin(),
                         story->touches.begin() + static_cast<std::ptrdiff_t>(touches));
      own.met.assign(story->met.begin(), story->met.begin() + static_cast<std::ptrdiff_t>(met));
      std::ranges::copy_if(story->meetings, std::back_inserter(own.meetings), is_before);
    }
  }
  hasten(from);
}

}  // namespace sleight::physics
