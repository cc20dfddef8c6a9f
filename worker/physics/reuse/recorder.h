// Records a running simulation as a recording, a history, or both.
//
// Invariants
//   1. A history's segments are stored only in its chunks; recording() copies them when called.
//   2. A history that exceeds its memory limit is discarded. If there is a recording, the history's
//      segments move to it.
// Thread safety: none.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "worker/physics/reuse/history_builder.h"
#include "worker/physics/reuse/recording.h"

namespace sleight::physics {

class Recorder {
 public:
  Recorder(std::size_t bodies, bool records, std::size_t segments_reserved);

  /// Starts a history. `records`: also provide a recording. REQUIRES: nothing has happened yet.
  void begin_history(std::size_t bytes_max, bool records);
  bool keeps_history() const { return builder_ != nullptr; }
  /// Whether a recording or a history is being written.
  bool is_used() const { return records_ || builder_ != nullptr; }

  // At an event, in any order.
  void begins(BodyId body, const Segment& segment, const EventKey& cause) {
    if (records_) recording_.append(body, segment, cause);
    if (builder_) builder_->begins(body);
  }
  /// Call if the event reads the body's state.
  void takes_part(BodyId body) {
    if (builder_) builder_->takes_part(body);
  }
  /// Call if the event changes the body's contact state in any other way than by adding a touch.
  void learns(BodyId body) {
    if (builder_) builder_->has_contact_state(body);
  }
  void touches(BodyId body, const TouchRecord& touch, bool slowly) {
    if (builder_) builder_->touches(body, touch, slowly);
  }
  void meets(double gap_m) {
    if (builder_) builder_->meet(gap_m);
  }
  void has_impact(double approach_mps, std::uint32_t noise_number) {
    if (builder_) builder_->has_impact(approach_mps, noise_number);
  }
  /// Ends the event. `state`: see HistoryBuilder::finish. REQUIRES: keeps_history().
  template <class State>
  void keep(const EventKey& event, const State& state) {
    builder_->takes_part(event.body());
    if (event.kind == EventKind::collision && !event.is_with_static())
      builder_->takes_part(event.other_body());
    builder_->finish(event, state);
    give_up_if_full();
  }

  // Replayed events.
  /// Call before an event is replayed.
  void give_up_if_full();
  /// Call after an event was replayed.
  void replayed(const HistoryEvent& event) {
    if (builder_) builder_->replayed(event);
  }
  /// Adds the reader's current event to the history. Call this for each event up to `last`, before
  /// the event's segments are recorded. If a chunk ends no later than `last`, the call for its
  /// first event shares the whole chunk.
  void takes_over(const HistoryReader& reader, Tick last);
  /// Records a segment of an event that takes_over() has added.
  void takes_over(BodyId body, const Segment& segment, const EventKey& cause) {
    if (records_) recording_.append(body, segment, cause);
  }

  /// The recording up to the last event; the caller sets its end.
  Recording& recording();
  /// The events so far. Empty if there is no history, or if it exceeded the memory limit.
  std::optional<HistoryChunks> history();

 private:
  void give_up();

  std::size_t bodies_;
  bool records_;
  bool records_without_history_ = true;
  Recording recording_;
  std::unique_ptr<HistoryBuilder> builder_;
  std::size_t recorded_ = 0;  ///< events of the history whose segments are in the recording
  std::size_t shared_ = 0;    ///< events of the reader that are already in the history
};

}  // namespace sleight::physics
