// The event loop, which works with any broad phase and any event queue.
//
// Asynchronous (thesis, Algorithms 3.2 and 3.3): each body has its own temporal bounding volume: a
// box that contains the body for a time span. When the span ends, the body gets a new box. If the
// last box overlapped few boxes, the new box lasts somewhat longer than the last one. If the last
// box overlapped many boxes, the new box lasts less long. When a body's motion changes, the body
// keeps its box if the box will still contain it for long enough. Pairs of overlapping boxes are
// watched. Every event affects one or two bodies.
//
// Synchronous (Algorithm 3.4): after every event, all bodies get new boxes, and all extents are
// sorted again. The boxes last until the next event.
//
// All pairs: the reference algorithm, without boxes.
//
// Invariants
//   1. From now to its expiry, a body's box contains the body and k_touch_m around it.
//   2. If the boxes of two bodies that may meet overlap, the pair has an edge. The edge's
//      prediction is not later than the pair's next collision. A body's key in the queue is its
//      earliest prediction (for pairs and static geometry) or its box's expiry, whichever is
//      earlier. If the least key's prediction is void (pair_graph.h), that key is recomputed. So
//      the least key that isn't void is the simulation's next event.
//   3. After lists have reached their full size, the loop allocates nothing.
// Hence the choice and timing of boxes don't affect the results. Thread safety: none.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "worker/physics/broad_phase/broad_phase.h"
#include "worker/physics/event/event_queue.h"
#include "worker/physics/simulator/any_engine.h"
#include "worker/physics/simulator/engine_options.h"
#include "worker/physics/simulator/replaying.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {

template <BroadPhase Boxes, EventQueue Queue>
class Engine final : public AnyEngine {
 public:
  /// See EngineMaker.
  Engine(World& world, Replaying& replaying, EngineOptions options,
         const std::optional<Takeover>& from);

  std::optional<SceneError> run_until(Tick end) override;
  Tick now() const override { return now_; }
  const Counts& counts() const override { return counts_; }
  Takeover state() const override { return {now_, counts_, failure_}; }

 private:
  static constexpr BodyId k_nobody{UINT32_MAX};

  /// Each body has a slot in the queue, with the body's number. The slots after these are for the
  /// kinds of events that belong to no body.
  enum class OwnSlot : std::uint32_t {
    control,    ///< next control of the scene
    sample,     ///< next sampling event
    new_boxes,  ///< new boxes of all bodies, in the synchronous algorithm
    replayed,   ///< next event of the replayed simulation
    count,
  };
  static Slot slot_of(BodyId body) { return {body}; }
  Slot slot_of(OwnSlot own) const { return {bodies_.size() + static_cast<std::uint32_t>(own)}; }

  struct Bound {
    Tick expiry = k_never;
    Tick made{};
  };
  struct StaticEdge {
    Prediction prediction{};
    StaticId index{};
    std::uint32_t search = k_no_search;
  };
  /// Receives the broad phase's reports on one body. finish() predicts new pairs in batches, unless
  /// the caller will predict all pairs of the body anyway.
  struct Sink {
    Engine& engine;
    BodyId body;
    bool predict;
    std::size_t begun = 0;  ///< pairs not predicted yet, at the end of the body's list
    void begin(BodyId other) {
      if (engine.begin_pair(body, other, false)) ++begun;
    }
    void end(BodyId other) {
      finish();  // removing an edge moves another edge to its place
      engine.end_pair(body, other);
    }
    void finish() {
      if (predict && begun > 0) engine.predict_last(body, begun);
      begun = 0;
    }
    std::span<const BodyId> neighbours() const { return engine.graph_.others_of(body); }
  };
  struct PairsSink {
    Engine& engine;
    void begin(BodyId a, BodyId b) {
      if (engine.begin_pair(a, b, true)) engine.refresh_key(a);
    }
    void end(BodyId a, BodyId b) { engine.end_pair(a, b); }
    std::span<const BodyId> neighbours(BodyId a) const { return engine.graph_.others_of(a); }
  };

  // Events.
  void process(const QueuedEvent& queued);
  bool is_void(BodyId body, const EventKey& event);
  void start(BodyId body, const EventKey& event);
  void collide(const EventKey& event);
  void examine(BodyId body, const EventKey& event);
  void control(const EventKey& event);
  void rest(const EventKey& event);
  void bodies_changed();
  void sample();

  // Replaying (engine_replay.h).
  bool starts_as_before(BodyId body, const EventKey& event);
  bool replay();
  void schedule_replay();
  void take_over_live();

  std::string obstacle_of(BodyId body);
  void watch(BodyId body);
  void unwatch(BodyId body);

  // Reading ahead.
  void fetch_next();
  void fetch_next_neighbours() const;

  // Predictions.
  /// Starts to watch a pair of bodies that may meet. Returns whether they may.
  bool begin_pair(BodyId a, BodyId b, bool predict);
  void end_pair(BodyId a, BodyId b);
  void predict(BodyId body, const PairEdge& edge);
  void predict_all(BodyId body);
  void predict_last(BodyId body, std::size_t count);
  void predict_statics(BodyId body);
  void refresh_key(BodyId body);

  // Bounding volumes.
  void motion_changed(BodyId body);
  void renew_box(BodyId body, bool predict);
  void renew_all_boxes(Tick end);
  bool watch_statics(BodyId body, const Box& box);
  TickCount least_span(BodyId body) const;
  /// Static geometry near a body. Doesn't read the body's list if the scene has no static geometry.
  std::span<StaticEdge> statics_of(BodyId body) {
    return world_.statics().any() ? std::span<StaticEdge>(statics_[body]) : std::span<StaticEdge>{};
  }

  void fail(SceneError::Kind kind, std::string message);
  void schedule_control();

  World& world_;
  const Bodies& bodies_;  ///< the world's
  Predictions& predictions_;
  Replaying& replaying_;
  EngineOptions options_;
  Boxes boxes_;
  Queue queue_;
  PairGraph graph_;
  std::vector<std::vector<StaticEdge>> statics_;
  std::vector<Bound> bounds_;
  std::vector<std::vector<StaticId>> candidates_;  ///< static features in static_boxes_
  std::vector<Box> static_boxes_;                  ///< boxes wider than the body's
  Tick boxes_until_ = k_never;                     ///< of the synchronous algorithm
  std::vector<Box> all_boxes_;                     ///< scratch of the synchronous algorithm
  std::vector<StaticId> near_;                     ///< scratch
  std::vector<std::uint32_t> changes_;             ///< by body: number of changes of its motion
  std::vector<std::uint8_t> is_watched_;
  std::vector<std::uint32_t> controls_;  ///< indices of controls in the order of their events
  std::size_t next_control_ = 0;
  std::uint32_t present_ = 0;  ///< number of bodies that have started
  bool reads_ahead_ = false;
  std::array<BodyId, 2> next_bodies_{k_nobody, k_nobody};  ///< probable bodies of the next event
  Tick now_{};
  Counts counts_;
  std::optional<SceneError> failure_;
};

}  // namespace sleight::physics
