// Options of an engine, and its counts.
//
// Thread safety: values.
#pragma once

#include <cstdint>
#include <functional>

#include "worker/physics/event/tick.h"

namespace sleight::physics {

/// Determines which bodies are updated after an event. All algorithms have the same results, bit
/// for bit.
enum class Algorithm : std::uint8_t {
  asynchronous,  ///< thesis, Algorithms 3.2 and 3.3: only the bodies involved
  synchronous,   ///< Algorithm 3.4: all bodies, as a baseline for comparison
  all_pairs      ///< no bounding volumes, predictions for every pair: the reference
};

struct EngineOptions {
  Algorithm algorithm = Algorithm::asynchronous;
  TickCount sample_every = 0;  ///< 0: no sampling events
  std::function<void(Tick)> on_sample{};
};

struct Counts {
  std::uint64_t updates = 0;     ///< bounding volumes that expired
  std::uint64_t examined = 0;    ///< searches for a collision that were resumed
  std::uint64_t collisions = 0;  ///< between two bodies
  std::uint64_t static_collisions = 0;
  std::uint64_t controls = 0;
  std::uint64_t starts = 0;
  std::uint64_t start_draws = 0;  ///< places drawn again because of an overlap
  std::uint64_t modes = 0;        ///< changes of lasting contacts, such as the end of a slide
  std::uint64_t rest_decisions = 0;
  std::uint64_t rests = 0;  ///< bodies that went to rest
  std::uint64_t samples = 0;
  std::uint64_t predictions = 0;
  std::uint64_t replayed = 0;  ///< events taken from a history
  std::uint64_t voids =
      0;  ///< events that were void when they came up, because a partner had changed

  Counts operator-(const Counts& earlier) const;

  std::uint64_t events() const {
    return updates + examined + collisions + static_collisions + controls + starts + samples +
           modes + rest_decisions;
  }
};

inline Counts Counts::operator-(const Counts& earlier) const {
  return {.updates = updates - earlier.updates,
          .examined = examined - earlier.examined,
          .collisions = collisions - earlier.collisions,
          .static_collisions = static_collisions - earlier.static_collisions,
          .controls = controls - earlier.controls,
          .starts = starts - earlier.starts,
          .start_draws = start_draws - earlier.start_draws,
          .modes = modes - earlier.modes,
          .rest_decisions = rest_decisions - earlier.rest_decisions,
          .rests = rests - earlier.rests,
          .samples = samples - earlier.samples,
          .predictions = predictions - earlier.predictions,
          .replayed = replayed - earlier.replayed,
          .voids = voids - earlier.voids};
}

}  // namespace sleight::physics
