// Stores everything that happened in a simulation, for reuse by a simulation of nearly the same
// scene (docs/SIMULATOR.md, "Replay of an earlier simulation").
//
// Idea. A history is a list of events in processing order. Each event names the bodies that took
// part, the segments that they began, and how their other state changed. So a reader of the list
// knows the bodies' state at any event, without predicting or resolving collisions. A recording
// (recording.h) has the same segments, sorted by body.
//
// Invariants
//   1. A body takes part in an event if the event changes or reads its state. So an event's effect
//      depends only on its participants' states, nearby static geometry and the scene's laws.
//   2. Once a history contains a chunk, the chunk doesn't change. Histories share chunks.
// Thread safety: threads may share a History for reading; the other types are not thread-safe.
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

/// A body that takes part in an event: its id, and flags that tell which of the event's lists have
/// data of the body.
struct Participant {
  static constexpr std::uint32_t k_begins = 1U << 31U;         ///< begins a segment
  static constexpr std::uint32_t k_touches = 1U << 30U;        ///< has a touch (Resting::touched)
  static constexpr std::uint32_t k_slowly = 1U << 29U;         ///< and that touch was slow
  static constexpr std::uint32_t k_contact_state = 1U << 28U;  ///< has its whole contact state
  std::uint32_t bits = 0;
  BodyId body() const { return {bits & (k_contact_state - 1)}; }
  bool begins() const { return (bits & k_begins) != 0; }
  bool touches() const { return (bits & k_touches) != 0; }
  bool slowly() const { return (bits & k_slowly) != 0; }
  bool has_contact_state() const { return (bits & k_contact_state) != 0; }
};

/// An event of a history. All lists are in the order of participants.
struct HistoryEvent {
  EventKey key;
  double gap_m = 0;         ///< for a collision of two bodies
  double approach_mps = 0;  ///< for a collision; see Impact
  std::uint32_t noise_number = 0;
  std::span<const Participant> participants;
  std::span<const Segment> segments;
  /// The list has one touch for each participant whose touches() is true, and the touches of all
  /// contact states. A contact state's touches begin at RestState::first_touch.
  std::span<const TouchRecord> touches;
  std::span<const ContactState> contact_states;
};

class HistoryChunk {
 public:
  std::size_t size() const { return events_.size(); }
  HistoryEvent event(std::size_t index) const;
  void append(const HistoryEvent& event);
  /// Reserves as much memory as another chunk uses.
  void reserve_like(const HistoryChunk& other);
  std::size_t bytes() const;

 private:
  struct Entry {
    EventKey key;
    double gap_m = 0;
    double approach_mps = 0;
    std::uint32_t noise_number = 0;
    // The index at which the event's range ends, in each list below.
    std::uint32_t participants = 0, segments = 0, touches = 0, contact_states = 0;
  };
  std::vector<Entry> events_;
  std::vector<Participant> participants_;
  std::vector<Segment> segments_;
  std::vector<TouchRecord> touches_;
  std::vector<ContactState> contact_states_;
};

using HistoryChunks = std::vector<std::shared_ptr<const HistoryChunk>>;

/// A simulation's events up to and including a tick. REQUIRES: the scene's shared meshes and
/// polyhedra don't change.
struct History {
  Scene scene;
  HistoryChunks chunks;
  Tick end{};  ///< last tick that the history covers
  /// Memory of this history in bytes. Other histories may share some of this memory.
  std::size_t bytes() const;
};

/// Iterates over the events of a list of chunks. Borrows the chunks.
class HistoryReader {
 public:
  HistoryReader() = default;
  explicit HistoryReader(const HistoryChunks& chunks) : chunks_(chunks) { find_event(); }
  bool at_end() const { return chunk_ == chunks_.size(); }
  // The functions below REQUIRE that the reader is not at the end.
  const HistoryEvent& event() const { return event_; }
  void next() {
    ++index_;
    find_event();
  }
  /// Returns the chunk if its first event is the current one, otherwise null.
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

class HistoryWriter {
 public:
  void append(const HistoryEvent& event);
  void share(std::shared_ptr<const HistoryChunk> chunk);
  /// Returns all chunks so far; later events go to new chunks.
  HistoryChunks chunks();
  std::size_t bytes() const { return closed_bytes_ + (open_ ? open_->bytes() : 0); }

 private:
  void close();
  HistoryChunks closed_;
  std::size_t closed_bytes_ = 0;
  std::shared_ptr<HistoryChunk> open_;
};

/// Skips the first `events_done` events, and appends the segments of all later ones to a recording.
/// Returns the number of events in the list.
std::size_t append_to(Recording& recording, const HistoryChunks& chunks, std::size_t events_done);

bool same_bits(const Segment& a, const Segment& b);
bool same_bits(const TouchRecord& a, const TouchRecord& b);

}  // namespace sleight::physics
