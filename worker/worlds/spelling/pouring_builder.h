// Builds pourings ball by ball for search (worker/sampling/stage_search.h).
//
// Balls drop one after another, and later balls seldom move earlier balls. So ball i is dropped
// where it would fill an empty bin alone. For this, the builder draws a drop from the map of
// landings or from a window around the bin, and simulates the ball alone. If each of the balls 0 to
// i then fills a bin, the drop is kept. The search never tries a drop if the ball needs another
// ball's push to reach its bin. So finds are plausible, but don't occur in the model's proportions.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/random/stream.h"
#include "worker/sampling/stage_search.h"
#include "worker/worlds/spelling/landing_map.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {

/// Balls that drop one after another, and the outcome of the balls dropped so far. Search builds
/// pourings, and islands extend them (pouring_stages.h).
struct Pouring {
  State state;  ///< balls that have not been dropped yet are inactive
  Outcome outcome;
};

Pouring no_balls(const Spelling& world, std::vector<Vec3> offsets_m);

/// Adds one ball, and simulates the result. REQUIRES: the ball is inactive.
Pouring with_ball(const Spelling& world, const Pouring& pouring, std::size_t ball,
                  const Vec2& drop_m);

/// A try fails after this number of simulated lone balls.
inline constexpr std::uint32_t k_lone_tries_max = 200;

class PouringBuilder {
 public:
  using Prefix = Pouring;

  /// REQUIRES: world and map outlive the builder.
  PouringBuilder(const Spelling& world, const LandingMap& map)
      : world_(&world), drops_(world, map) {}

  std::uint32_t stages() const { return world_->balls(); }
  sampling::SearchLimits limits() const { return {}; }
  /// Draws a box from the prior, and returns it without balls.
  Prefix start(random::Stream& stream) const;
  std::optional<Prefix> attempt(const Prefix& prefix, std::uint32_t stage,
                                sampling::SearchEffort& effort, random::Stream& stream) const;
  bool is_solution(const Prefix& prefix) const { return world_->satisfied(prefix.outcome); }
  const State& state_of(const Prefix& prefix) const { return prefix.state; }
  const Outcome& outcome_of(const Prefix& prefix) const { return prefix.outcome; }

 private:
  /// Returns a drop from which the next ball would fill an empty bin if it fell alone. After
  /// k_lone_tries_max tries, returns nothing.
  std::optional<Vec2> promising_drop(const Prefix& prefix, sampling::SearchEffort& effort,
                                     random::Stream& stream) const;

  const Spelling* world_;
  BinDrops drops_;
};

static_assert(sampling::StageBuilder<PouringBuilder>);

}  // namespace sleight::worlds::spelling
