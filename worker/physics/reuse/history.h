// All that happened in a simulation, so that one of nearly the same scene need not compute it again
// (docs/SIMULATOR.md, "Replay of an earlier simulation").
//
// Idea. A list of events in the order in which they were processed. Each names the bodies that took
// part in it, the segments that they began, and the changes of the rest of their state. So at each
// event a reader of the list has the state that a simulation would have of these bodies, without
// predictions and without resolving a collision. A recording (recording.h) is the same segments by
// body.
//
// Invariants
//   1. A body takes part in an event if the event changes or reads its state. So an event's effect
//      is a function of its participants' states, of static geometry near them, and of the scene's
//      laws.
//   2. Chunks do not change once a history has them, and histories share them.
// Thread safety: a History is shared between threads that read it; the rest none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "worker/physics/contact/contact_state.h"
#include "worker/physics/event/event.h"
#include "worker/physics/motion/segment.h"
#include "worker/physics/reuse/recording.h"
#include "worker/physics/scene/scene.h"

namespace sleight::physics {

/// A body's part in an event: its id, and flags for what follows in the event's lists.
struct Participant {
  static constexpr std::uint32_t k_begins = 1U << 31U;         ///< a segment
  static constexpr std::uint32_t k_touches = 1U << 30U;        ///< something, as Resting::touched
  static constexpr std::uint32_t k_slowly = 1U << 29U;         ///< and that was slow
  static constexpr std::uint32_t k_contact_state = 1U << 28U;  ///< all that it knows
  std::uint32_t bits = 0;
  BodyId body() const { return {bits & (k_contact_state - 1)}; }
  bool begins() const { return (bits & k_begins) != 0; }
  bool touches() const { return (bits & k_touches) != 0; }
  bool slowly() const { return (bits & k_slowly) != 0; }
  bool has_contact_state() const { return (bits & k_contact_state) != 0; }
};

/// An event of a history. Lists are in the order of participants.
struct HistoryEvent {
  EventKey key;
  double gap_m = 0;  ///< of a collision of two bodies
  std::span<const Participant> participants;
  std::span<const Segment> segments;
  /// One for each that touches, and as many as each with a contact state has: RestState says
  /// where.
  std::span<const TouchRecord> touches;
  std::span<const ContactState> contact_states;
};

/// Some hundreds of events that follow one another.
class HistoryChunk {
 public:
  std::size_t size() const { return events_.size(); }
  HistoryEvent event(std::size_t index) const;
  void append(const HistoryEvent& event);
  /// Room for as much as another one has.
  void reserve_like(const HistoryChunk& other);
  std::size_t bytes() const;

 private:
  struct Entry {
    EventKey key;
    double gap_m = 0;
    // Where its parts of the lists end.
    std::uint32_t participants = 0, segments = 0, touches = 0, contact_states = 0;
  };
  std::vector<Entry> events_;
  std::vector<Participant> participants_;
  std::vector<Segment> segments_;
  std::vector<TouchRecord> touches_;
  std::vector<ContactState> contact_states_;
};

using HistoryChunks = std::vector<std::shared_ptr<const HistoryChunk>>;

/// The events of a simulation up to and at a tick. REQUIRES: the meshes and polyhedra that its
/// scene shares stay as they are.
struct History {
  Scene scene;
  HistoryChunks chunks;
  Tick end{};  ///< the history holds everything up to and at it
  /// Memory, of which some may be shared with other histories.
  std::size_t bytes() const;
};

/// Goes through a list of chunks. Borrows them.
class HistoryReader {
 public:
  HistoryReader() = default;
  explicit HistoryReader(const HistoryChunks& chunks) : chunks_(chunks) { find_event(); }
  bool at_end() const { return chunk_ == chunks_.size(); }
  // REQUIRES, of the rest: not at the end.
  const HistoryEvent& event() const { return event_; }
  void next() {
    ++index_;
    find_event();
  }
  /// The whole chunk, if its first event is the next one; else null.
  std::shared_ptr<const HistoryChunk> whole_chunk() const {
    return index_ == 0 ? chunks_[chunk_] : nullptr;
  }

 private:
  void find_event();
  std::span<const std::shared_ptr<const HistoryChunk>> chunks_;
  std::size_t chunk_ = 0;
  std::size_t index_ = 0;
  HistoryEvent event_;
};

/// Collects events.
class HistoryWriter {
 public:
  void append(const HistoryEvent& event);
  /// Appends a chunk as it is.
  void share(std::shared_ptr<const HistoryChunk> chunk);
  /// All so far; what comes later is not in it.
  HistoryChunks chunks();
  std::size_t bytes() const { return closed_bytes_ + (open_ ? open_->bytes() : 0); }

 private:
  void close();
  HistoryChunks closed_;
  std::size_t closed_bytes_ = 0;
  std::shared_ptr<HistoryChunk> open_;
};

/// Appends to a recording the segments of events from some place in a list on; the place after the
/// last one.
std::size_t append_to(Recording& recording, const HistoryChunks& chunks, std::size_t events_done);

/// Whether two segments are the same, bit for bit.
bool same_bits(const Segment& a, const Segment& b);

}  // namespace sleight::physics
