// Pourings built ball by ball, for search (worker/sampling/stage_search.h).
//
// Balls drop one after another, and later balls seldom move earlier ones. So ball i is dropped
// where it would fill an empty bin alone: draw a drop from the map of landings or from a window
// around the bin, then simulate the ball alone. The drop is kept if, after it, each of the balls 0
// to i fills a bin. Balls that reach their bin only with another ball's push are never tried. So
// finds are plausible, but don't occur in the model's proportions.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <cstdint>
#include <optional>

#include "common/random/stream.h"
#include "worker/sampling/stage_search.h"
#include "worker/worlds/spelling/landing_map.h"
#include "worker/worlds/spelling/pouring.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {

/// Number of lone balls that are simulated before a try counts as failed.
inline constexpr std::uint32_t k_lone_tries_max = 200;

class PouringBuilder {
 public:
  using Prefix = Pouring;

  /// REQUIRES: world and map outlive the builder.
  PouringBuilder(const Spelling& world, const LandingMap& map)
      : world_(&world), drops_(world, map) {}

  std::uint32_t stages() const { return world_->balls(); }
  sampling::SearchLimits limits() const { return {}; }
  /// Returns a box drawn from the prior, without balls.
  Prefix start(random::Stream& stream) const;
  std::optional<Prefix> attempt(const Prefix& prefix, std::uint32_t stage,
                                sampling::SearchEffort& effort, random::Stream& stream) const;
  bool is_solution(const Prefix& prefix) const { return world_->satisfied(prefix.outcome); }
  const State& state_of(const Prefix& prefix) const { return prefix.state; }
  const Outcome& outcome_of(const Prefix& prefix) const { return prefix.outcome; }

 private:
  /// Returns a drop with which the next ball would fill an empty bin alone. Nothing after
  /// k_lone_tries_max tries.
  std::optional<Vec2> promising_drop(const Prefix& prefix, sampling::SearchEffort& effort,
                                     random::Stream& stream) const;

  const Spelling* world_;
  BinDrops drops_;
};

static_assert(sampling::StageBuilder<PouringBuilder>);

}  // namespace sleight::worlds::spelling
