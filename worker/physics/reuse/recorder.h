// What a running simulation leaves behind: a recording, a history, or both, and what it collects
// for them while an event takes place.
//
// Invariants
//   1. A history's segments are in its chunks alone; the recording gets them when it is asked for.
//   2. A history that has grown beyond its limit is given up. What it had by then goes to the
//      recording, if one is wanted.
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

  /// From now on, for history(). `records`: a recording is wanted as well. REQUIRES: nothing has
  /// happened yet.
  void begin_history(std::size_t bytes_max, bool records);
  bool keeps_history() const { return builder_ != nullptr; }
  /// Whether either is kept at present.
  bool is_used() const { return records_ || builder_ != nullptr; }

  // At an event, in any order.
  void begins(BodyId body, const Segment& segment, const EventKey& cause) {
    if (records_) recording_.append(body, segment, cause);
    if (builder_) builder_->begins(body);
  }
  /// Its state is read.
  void takes_part(BodyId body) {
    if (builder_) builder_->takes_part(body);
  }
  /// What it knows is about to change, or has, in more than what it touches.
  void learns(BodyId body) {
    if (builder_) builder_->has_contact_state(body);
  }
  void touches(BodyId body, const TouchRecord& touch, bool slowly) {
    if (builder_) builder_->touches(body, touch, slowly);
  }
  void meets(double gap_m) {
    if (builder_) builder_->meet(gap_m);
  }
  /// The event is over. state: as HistoryBuilder::finish asks for it. REQUIRES: keeps_history().
  template <class State>
  void keep(const EventKey& event, const State& state) {
    builder_->takes_part(event.body());
    if (event.kind == EventKind::collision && !event.is_with_static())
      builder_->takes_part(event.other_body());
    builder_->finish(event, state);
    give_up_if_full();
  }

  // Events that are an earlier history's as well.
  /// Before one of them is replayed.
  void give_up_if_full();
  /// One has been replayed.
  void replayed(const HistoryEvent& event) {
    if (builder_) builder_->replayed(event);
  }
  /// For each event of a reader up to `last`, before its segments: the event goes into the history.
  /// Of chunks that end by then the whole is shared when their first one comes.
  void takes_over(const HistoryReader& reader, Tick last);
  /// A segment of such an event.
  void takes_over(BodyId body, const Segment& segment, const EventKey& cause) {
    if (records_) recording_.append(body, segment, cause);
  }

  /// Up to the last event. Its end is the caller's affair.
  Recording& recording();
  /// All that happened; nothing if it isn't kept, or is too much.
  std::optional<HistoryChunks> history();

 private:
  void give_up();

  std::size_t bodies_;
  bool records_;
  bool records_without_history_ = true;
  Recording recording_;
  std::unique_ptr<HistoryBuilder> builder_;
  std::size_t recorded_ = 0;  ///< events of the history whose segments are in the recording
  std::size_t shared_ = 0;    ///< events of a reader that are the history's already
};

}  // namespace sleight::physics
