// What a simulation leaves behind: per body the list of its segments, each with the event that
// began it. From it any body's state at any tick is had without a simulator.
//
// A segment holds from its tick up to the next segment's; the last one up to the end of the
// recording. A body has no state before its first segment (it has not started yet).
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
  /// Room for so many segments of each body before anything is allocated.
  void reset(std::size_t bodies, std::size_t segments_reserved);
  void append(BodyId body, const Segment& segment, const EventKey& cause);
  void end_at(Tick end) { end_ = end; }

  struct Entry {
    Segment segment;
    EventKey cause;
  };
  std::size_t bodies() const { return of_body_.size(); }
  std::span<const Entry> segments(BodyId body) const { return of_body_[body.value]; }
  /// The simulation stopped here: later states are not known.
  Tick end() const { return end_; }
  std::size_t segment_count() const;

  /// The segment in force at a tick, the last if several begin there; null before the body started.
  const Segment* segment_at(BodyId body, Tick tick) const;

  /// A hash of every bit: equal recordings have equal hashes.
  std::uint64_t digest() const;

 private:
  std::vector<std::vector<Entry>> of_body_;
  Tick end_{};
};

}  // namespace sleight::physics
