// Stores the segments of each body of a simulation, and the event that began each segment. A
// recording defines each body's state at any tick; no simulator is needed.
//
// A segment is valid from its tick up to the tick of the next segment. The last segment is valid up
// to the recording's end. Before its first segment, a body hasn't started and has no state.
// Thread safety: a value.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/event/event.h"
#include "worker/physics/motion/segment.h"

namespace sleight::physics {

class Recording {
 public:
  /// Clears the recording and reserves memory for this many segments per body.
  void reset(std::size_t bodies, std::size_t segments_reserved);
  void append(BodyId body, const Segment& segment, const EventKey& cause);
  void end_at(Tick end) { end_ = end; }

  struct Entry {
    Segment segment;
    EventKey cause;
  };
  std::size_t bodies() const { return of_body_.size(); }
  std::span<const Entry> segments(BodyId body) const { return of_body_[body.value]; }
  /// End of the simulation; later states are unknown.
  Tick end() const { return end_; }
  std::size_t segment_count() const;

  /// Returns the segment at a tick (the last if several begin there); null before the body started.
  const Segment* segment_at(BodyId body, Tick tick) const;

  /// Hash of all bits: equal recordings have equal hashes.
  std::uint64_t digest() const;

 private:
  std::vector<std::vector<Entry>> of_body_;
  Tick end_{};
};

}  // namespace sleight::physics
