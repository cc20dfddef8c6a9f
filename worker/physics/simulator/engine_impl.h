// Implementation of the templates in engine.h. Only simulation.cpp (the product's engine) and
// tests/engines include this header.
#pragma once

#include <fmt/format.h>

#include <algorithm>

#include "worker/physics/event/tolerances.h"
#include "worker/physics/simulator/engine.h"
#include "worker/physics/simulator/engine_boxes.h"
#include "worker/physics/simulator/engine_replay.h"

namespace sleight::physics {

/// Initial capacity of each list of neighbours: at most 12 equal spheres touch a sphere of the same
/// size, and boxes extend somewhat further. A larger capacity would spread the lists over memory.
inline constexpr std::size_t k_list_room = 16;
/// Memory is reserved for this many neighbours per body, on average.
inline constexpr std::size_t k_list_average = 48;
/// Initial capacity of each body's list of the static geometry near it. During an update, a list
/// may be twice as long as usual.
inline constexpr std::size_t k_static_room = 96;
/// Initial capacity of each body's list of static candidates. Each new box tests them.
inline constexpr std::size_t k_candidate_room = 256;
/// If there are at least this many bodies, the next event's data are prefetched. The data of fewer
/// bodies fit in the second-level cache: prefetching would slow a gas of 1,000 spheres by 5%.
inline constexpr std::uint32_t k_read_ahead_bodies = 4000;

template <BroadPhase Boxes, EventQueue Queue>
Engine<Boxes, Queue>::Engine(World& world, Replaying& replaying, EngineOptions options,
                             const std::optional<Takeover>& from)
    : world_(world),
      bodies_(world.bodies()),
      predictions_(world.predictions()),
      replaying_(replaying),
      options_(std::move(options)),
      boxes_({.bodies = bodies_.size(),
              .period_m = bodies_.scene().period_m,
              .size_m = typical_box_m(bodies_)}) {
  if (from) {
    now_ = from->now;
    counts_ = from->counts;
    failure_ = from->failure;
  }
  const auto count = bodies_.size();
  queue_.reset(slot_of(OwnSlot::count).value);
  graph_.reset(count, options_.algorithm == Algorithm::all_pairs
                          ? PairGraph::Room{.list = std::max(count, 1U), .average = 0}
                          : PairGraph::Room{.list = k_list_room,
                                            .average = k_list_average,
                                            .details = !world.only_flies()});
  statics_.resize(count);
  candidates_.resize(count);
  for (BodyId body{}; body < count; ++body) {
    statics_[body].reserve(world_.statics().count(body) > 0 ? k_static_room : 0);
    candidates_[body].reserve(world_.statics().count(body) > 0 ? k_candidate_room : 0);
  }
  near_.reserve(k_static_room);
  bounds_.resize(count);
  static_boxes_.resize(count);
  changes_.assign(count, 0);
  is_watched_.assign(count, 0);
  reads_ahead_ = count >= k_read_ahead_bodies;
  if (options_.algorithm == Algorithm::synchronous) all_boxes_.resize(count);

  // Take over bodies that have started. Give all other bodies start events.
  predictions_.forget_searches(options_.algorithm != Algorithm::all_pairs);
  for (BodyId body{}; body < count; ++body) {
    if (bodies_.started(body)) {
      ++present_;
      watch(body);
    } else {
      queue_.set(slot_of(body), {.tick = bodies_.scene().bodies[body].start_tick,
                                 .kind = EventKind::start,
                                 .lower = body});
    }
  }
  for (BodyId body{}; body < count; ++body) {
    if (bodies_.started(body)) motion_changed(body);
  }
  schedule_replay();
  take_over_live();
  const std::vector<Control>& controls = bodies_.scene().controls;
  controls_ = controls_in_order(bodies_.scene());
  while (from && next_control_ < controls_.size() &&
         controls[controls_[next_control_]].tick <= now_) {
    ++next_control_;
  }
  schedule_control();
  if (options_.sample_every > 0) {
    const TickCount every = options_.sample_every;
    queue_.set(slot_of(OwnSlot::sample), {.tick = Tick{from ? (now_.value / every + 1) * every : 0},
                                          .kind = EventKind::sample});
  }
}

/// Finds what is near a newly placed body, without predictions.
template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::watch(BodyId body) {
  bounds_[body].made = now_ - 1;
  static_boxes_[body] = {.low_m = {1, 1, 1}, .high_m = {-1, -1, -1}};
  for (StaticEdge& edge : statics_[body])
    predictions_.end_search(edge.search);
  statics_[body].clear();
  if (options_.algorithm == Algorithm::all_pairs) {
    for (BodyId other{}; other < bodies_.size(); ++other) {
      if (other != body && is_watched_[other] != 0) begin_pair(body, other, false);
    }
    for (StaticId index{}; index < world_.statics().count(body); ++index) {
      if (world_.statics().meets(body, index)) statics_[body].push_back({.index = index});
    }
    if (replaying_.statics_differ()) world_.replayed().make_live(body);
  } else {
    const Box box = path_box(bodies_.path(body), bodies_.reach_m(body) + k_touch_m, now_, now_ + 1);
    Sink sink{*this, body, false};
    boxes_.insert(body, box, sink);
    replaying_.comes_into(body, box);
    watch_statics(body, box);
  }
  is_watched_[body] = 1;
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::unwatch(BodyId body) {
  if (options_.algorithm == Algorithm::all_pairs) {
    while (!graph_.others_of(body).empty())
      end_pair(body, graph_.others_of(body).front());
  } else {
    Sink sink{*this, body, false};
    boxes_.remove(body, sink);
  }
  is_watched_[body] = 0;
}

template <BroadPhase Boxes, EventQueue Queue>
std::optional<SceneError> Engine<Boxes, Queue>::run_until(Tick end) {
  if (end < now_) return failure_;
  // The last call of run_until() made boxes that are valid only until the end of its time span.
  if (options_.algorithm == Algorithm::synchronous) renew_all_boxes(end);
  take_over_live();
  while (!failure_ && !queue_.empty()) {
    const QueuedEvent event = queue_.least();
    if (event.key.tick > end) break;
    // If an event were before the present, a bound would be wrong: a collision was found too late.
    CHECK_GE(event.key.tick.value, now_.value);
    now_ = event.key.tick;
    if (reads_ahead_) fetch_next();
    process(event);
    if (world_.has_failed()) [[unlikely]]
      failure_ = world_.failure();
    if (options_.algorithm == Algorithm::synchronous) renew_all_boxes(end);
    if (!world_.replayed().gone_live().empty()) take_over_live();
  }
  if (!failure_) now_ = end;
  return failure_;
}

// ---- events -------------------------------------------------------------------------------------

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::process(const QueuedEvent& queued) {
  const EventKey& event = queued.key;
  if (queued.slot == slot_of(OwnSlot::replayed)) {
    replay();
    return;
  }
  switch (event.kind) {
    case EventKind::update:
      if (event.body() == k_nobody) return;  // new boxes for the synchronous algorithm
      if (event.higher == k_nobody) {
        ++counts_.updates;
        renew_box(event.body(), true);
      } else {
        examine({queued.slot.value}, event);
      }
      return;
    case EventKind::start:
      start(event.body(), event);
      return;
    case EventKind::control:
      control(event);
      return;
    case EventKind::collision:
      if (is_void({queued.slot.value}, event)) {
        ++counts_.voids;
        refresh_key({queued.slot.value});
      } else {
        collide(event);
      }
      return;
    case EventKind::sample:
      sample();
      return;
    case EventKind::rest:
      rest(event);
      return;
    case EventKind::mode:
      if (bodies_.stays_on_faces(event.body())) {
        ++counts_.modes;
        world_.change_mode(event.body(), event);
        world_.keep(event);
        bodies_changed();
        return;
      }
      fail(SceneError::Kind::spins_too_long,
           fmt::format("{} spins too fast for too long without any contact, at {:.9g} s",
                       bodies_.name(event.body()), seconds(now_ - Tick{})));
      return;
  }
  CHECK(false);
}

/// Whether a prediction is void: the partner's motion has changed since the prediction, or the pair
/// is no longer watched.
template <BroadPhase Boxes, EventQueue Queue>
bool Engine<Boxes, Queue>::is_void(BodyId body, const EventKey& event) {
  if (event.is_with_static()) return false;
  const auto edge = graph_.find(body, body == event.body() ? event.other_body() : event.body());
  return !edge || *edge->other_changes != changes_[edge->other];
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::start(BodyId body, const EventKey& event) {
  const BodyDescription& description = bodies_.scene().bodies[body];
  StartState state = description.start;
  for (std::uint32_t attempt = 1;; ++attempt) {
    // Place the body, to find out what it would touch.
    world_.place(body, description.rests || description.fixed
                           ? world_.segment_at_rest(body)
                           : bodies_.segment_of_start(state, event.tick));
    watch(body);
    const std::string obstacle = obstacle_of(body);
    if (obstacle.empty()) break;

    // Remove the body. If its description has another start, try that one.
    unwatch(body);
    if (!description.start_again || attempt > k_start_attempts_max) {
      fail(
          SceneError::Kind::overlap,
          description.start_again
              ? fmt::format("{} can't start at {:.9g} s: no free place was found in {} attempts; "
                            "the last place overlaps {}",
                            bodies_.name(body), seconds(event.tick - Tick{}), attempt - 1, obstacle)
              : fmt::format("{} can't start at {:.9g} s: it overlaps {}, or the gap is below {} m",
                            bodies_.name(body), seconds(event.tick - Tick{}), obstacle, k_touch_m));
      return;
    }
    ++counts_.start_draws;
    state = description.start_again(attempt);
    if (auto wrong = error_of_start(state, bodies_.name(body))) {
      failure_ = std::move(wrong);
      return;
    }
  }
  ++counts_.starts;
  ++present_;
  world_.begin_segment(body, bodies_.segment(body), event);
  if (description.rests) world_.begin_at_rest(body);
  world_.keep(event);
  if (replaying_.active()) starts_as_before(body, event);
  ++changes_[body];
  motion_changed(body);
}

/// Returns the name of what a body overlaps; empty if nothing.
template <BroadPhase Boxes, EventQueue Queue>
std::string Engine<Boxes, Queue>::obstacle_of(BodyId body) {
  // Fixed bodies have been placed before all starts, and other bodies avoid them.
  if (bodies_.is_fixed(body)) return "";
  // If both bodies start at rest or one is fixed, World::lay_down has already checked the pair.
  const std::vector<BodyDescription>& bodies = bodies_.scene().bodies;
  const bool rests = bodies[body].rests;
  BodyId lowest = k_nobody;
  const auto look = [&](BodyId other) {
    if (rests && (bodies[other].rests || bodies[other].fixed)) return;
    const BodyId a = std::min(body, other);
    const BodyId b = std::max(body, other);
    if (other < lowest && predictions_.touching(a, b, now_)) lowest = other;
  };
  for (const BodyId other : graph_.others_of(body))
    look(other);
  for (const BodyId other : bodies_.fixed()) {
    if (!bodies_.started(other) && bodies_.may_meet(body, other)) look(other);
  }
  if (lowest != k_nobody) return bodies_.name(lowest);
  if (rests) return "";
  for (const StaticEdge& edge : statics_[body]) {
    if (world_.statics().touching(body, edge.index, now_))
      return world_.statics().name(body, edge.index);
  }
  // A body deep inside a solid may touch nothing of the solid's surface.
  return world_.statics().solid_at(body, bodies_.position_at(body, now_));
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::collide(const EventKey& event) {
  if (event.is_with_static()) {
    ++counts_.static_collisions;
    world_.collide_static(event.body(), event.met(), event);
  } else {
    ++counts_.collisions;
    world_.collide(event.body(), event.other_body(), event);
  }
  world_.keep(event);
  bodies_changed();
}

/// If a body began a segment at this event, gives it new bounds and predictions.
template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::bodies_changed() {
  // Update all change numbers before predicting: if they change later, a prediction becomes void.
  for (const BodyId body : world_.changed())
    ++changes_[body];
  for (const BodyId body : world_.changed()) {
    motion_changed(body);
    if (body == world_.changed().front()) fetch_next_neighbours();
  }
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::rest(const EventKey& event) {
  ++counts_.rest_decisions;
  const std::size_t rested = world_.rest(event.body(), event);
  counts_.rests += rested;
  world_.keep(event);
  bodies_changed();
  if (rested == 0) refresh_key(event.body());
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::examine(BodyId body, const EventKey& event) {
  if (is_void(body, event)) {
    ++counts_.voids;
  } else if (event.is_with_static()) {
    ++counts_.examined;
    const StaticId index = event.met();
    for (StaticEdge& edge : statics_[body]) {
      if (edge.index == index)
        edge.prediction =
            predictions_.look_static(body, index, now_, edge.search, bounds_[body].expiry);
    }
  } else {
    ++counts_.examined;
    const PairEdge edge =
        *graph_.find(body, body == event.body() ? event.other_body() : event.body());
    if (options_.algorithm == Algorithm::all_pairs && bodies_.periodic()) {
      predict(body, edge);
    } else {
      CHECK(edge.detail != nullptr);
      edge.predict(predictions_.look(event.body(), event.other_body(), now_, edge.detail->search));
    }
  }
  refresh_key(body);
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::control(const EventKey& event) {
  const Control& control = bodies_.scene().controls[controls_[next_control_]];
  ++counts_.controls;
  ++next_control_;
  schedule_control();
  const BodyId body = control.body;
  if (!bodies_.started(body)) {
    schedule_replay();
    return;
  }
  if (world_.replayed().has(body) && event.feature < replaying_.same_controls()) {
    CHECK(replaying_.next() == event);
    if (replay()) return;
  }
  world_.apply(control, event);
  world_.keep(event);
  bodies_changed();
  schedule_replay();  // skips the history's events of this body
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::schedule_control() {
  if (next_control_ == controls_.size()) {
    queue_.erase(slot_of(OwnSlot::control));
    return;
  }
  const Control& control = bodies_.scene().controls[controls_[next_control_]];
  queue_.set(slot_of(OwnSlot::control), {.tick = control.tick,
                                         .kind = EventKind::control,
                                         .lower = control.body,
                                         .feature = static_cast<std::uint32_t>(next_control_)});
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::sample() {
  ++counts_.samples;
  if (options_.on_sample) options_.on_sample(now_);
  queue_.set(slot_of(OwnSlot::sample),
             {.tick = now_ + options_.sample_every, .kind = EventKind::sample});
}

// ---- reading ahead ------------------------------------------------------------------------------

// If a simulation has many bodies, most of an event's data are not in the caches: processing waits
// for one list or box after another. The next event is usually known. So while this event is
// processed, the next one's data are prefetched: first its bodies' data and lists, then their
// neighbours' data. The neighbours' boxes are left out, because prefetching them slows gases down.

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::fetch_next() {
  if constexpr (requires { queue_.second(); }) {
    const EventKey& next = queue_.key_of(queue_.second());
    next_bodies_ = {
        next.lower < bodies_.size() ? next.body() : k_nobody,
        next.higher < bodies_.size() && next.higher != next.lower ? next.other_body() : k_nobody};
    for (const BodyId body : next_bodies_) {
      if (body == k_nobody) continue;
      world_.fetch(body);
      graph_.fetch(body);
      __builtin_prefetch(&bounds_[body], 1);
      if constexpr (requires { boxes_.fetch(body); }) boxes_.fetch(body);
    }
  }
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::fetch_next_neighbours() const {
  for (const BodyId body : next_bodies_) {
    if (body == k_nobody) continue;
    for (const BodyId other : graph_.others_of(body))
      bodies_.fetch_flight(other);
  }
}

// ---- predictions --------------------------------------------------------------------------------

template <BroadPhase Boxes, EventQueue Queue>
bool Engine<Boxes, Queue>::begin_pair(BodyId a, BodyId b, bool predict_now) {
  if (!bodies_.may_meet(a, b)) return false;
  graph_.add(a, b);
  if (predict_now) predict_last(a, 1);
  return true;
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::end_pair(BodyId a, BodyId b) {
  if (!bodies_.may_meet(a, b)) return;
  std::uint32_t search = graph_.remove(a, b);
  predictions_.end_search(search);
}

/// Predicts a pair. Stores the prediction in this body's copy of the edge. The partner's copy
/// becomes void.
template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::predict(BodyId body, const PairEdge& edge) {
  *edge.other_changes = changes_[edge.other];
  if (world_.replayed().has(body) && world_.replayed().has(edge.other)) {
    edge.predict({});
    return;
  }
  ++counts_.predictions;
  const BodyId lower = std::min(body, edge.other);
  const BodyId higher = std::max(body, edge.other);
  if (predictions_.free_spheres(lower, higher) && options_.algorithm != Algorithm::all_pairs) {
    edge.predict(predictions_.predict_free_spheres(lower, higher, now_));
    return;
  }
  if (options_.algorithm == Algorithm::all_pairs && bodies_.periodic()) {
    edge.predict(predictions_.predict_any_image(lower, higher, now_));
    return;
  }
  CHECK(edge.detail != nullptr);
  std::uint32_t search = edge.detail->search;
  edge.predict(predictions_.predict(lower, higher, now_, search));
  if (search == edge.detail->search) return;
  edge.detail->search = search;
  graph_.find(edge.other, body)->detail->search = search;
}

/// Predicts all pairs of a body whose motion has changed, and updates its key.
template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::predict_all(BodyId body) {
  predict_last(body, graph_.edges_of(body).count);
  predict_statics(body);
  refresh_key(body);
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::predict_last(BodyId body, std::size_t count) {
  const PairEdges all = graph_.edges_of(body);
  const PairEdges edges = all.from(all.count - count, count);
  const bool flies = options_.algorithm != Algorithm::all_pairs &&
                     predictions_.in_free_flight(body) && !world_.replayed().has(body);
  if (flies && predictions_.predict_flight(body, edges, changes_, now_)) {
    counts_.predictions += count;
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (flies && predictions_.in_free_flight(edges.others[i])) {
      ++counts_.predictions;
    } else {
      predict(body, edges[i]);
    }
  }
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::predict_statics(BodyId body) {
  if (world_.replayed().has(body)) return;
  // Predictions aren't needed beyond the tick at which the body's motion first changes.
  Tick until = std::min(bounds_[body].expiry, world_.mode_end(body));
  for (StaticEdge& edge : statics_of(body)) {
    ++counts_.predictions;
    edge.prediction = predictions_.predict_static(body, edge.index, now_, edge.search, until);
    if (edge.prediction.certain) until = std::min(until, edge.prediction.tick);
  }
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::refresh_key(BodyId body) {
  EventKey best{
      .tick = bounds_[body].expiry, .kind = EventKind::update, .lower = body, .higher = k_nobody};
  const auto offer = [&](const auto& prediction, std::uint32_t lower, std::uint32_t higher) {
    const EventKey key{.tick = prediction.tick,
                       .kind = prediction.certain ? EventKind::collision : EventKind::update,
                       .lower = lower,
                       .higher = higher,
                       .feature = prediction.feature};
    if (key < best) best = key;
  };
  // First find the least tick, in a loop without branches. Then compare the whole keys of
  // predictions at that tick.
  const PairEdges edges = graph_.edges_of(body);
  const auto is_void = [&](std::size_t i) {
    return edges.other_changes[i] != changes_[edges.others[i]];
  };
  Tick least = k_never;
  for (std::size_t i = 0; i < edges.count; ++i)
    least = std::min(least, is_void(i) ? k_never : edges.ticks[i]);
  for (std::size_t i = 0; least <= best.tick && i < edges.count; ++i) {
    if (edges.ticks[i] != least || is_void(i)) continue;
    offer(edges[i].prediction(), std::min(body, edges.others[i]), std::max(body, edges.others[i]));
  }
  if (world_.replayed().has(body)) {
    queue_.set(slot_of(body), best);  // the history has its other events
    return;
  }
  for (const StaticEdge& edge : statics_of(body)) {
    if (edge.prediction.tick <= best.tick) offer(edge.prediction, body, k_static | edge.index);
  }
  const Tick rest_due = world_.rest_due(body);
  if (rest_due < best.tick) best = {.tick = rest_due, .kind = EventKind::rest, .lower = body};
  const Tick mode_end = world_.mode_end(body);
  if (mode_end < best.tick || (mode_end == best.tick && best.kind > EventKind::mode))
    best = {.tick = mode_end, .kind = EventKind::mode, .lower = body};
  queue_.set(slot_of(body), best);
}

// ---- failures -----------------------------------------------------------------------------------

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::fail(SceneError::Kind kind, std::string message) {
  failure_ = SceneError{kind, std::move(message)};
}

}  // namespace sleight::physics
