// The search of scenes, front to back.
//
// A stage is a set of constraints that are decided together (Stage in judge.h). Once they are met,
// the noise of later impacts, and of the impact that decided, can't undo this. So the next stage
// draws only that noise afresh, and replays all before. A scene without noise has one stage.
//
//   First stage:   some draws from the prior, then an annealed walk from the best of them.
//   Later stages:  some fresh tails, then sometimes an annealed walk of shots from the best of
//   them.
//
// Thread safety: as UserScene's.
#pragma once

#include <cstdint>
#include <optional>

#include "common/random/stream.h"
#include "worker/sampling/stage_search.h"
#include "worker/worlds/user_scene/user_scene.h"

namespace sleight::worlds::user_scene {

class SceneSearch {
 public:
  struct Prefix {
    State state;
    Outcome outcome;
  };

  /// REQUIRES: the world outlives the search.
  explicit SceneSearch(const UserScene& world) : world_(&world) {}

  std::uint32_t stages() const { return world_->stages(); }
  sampling::SearchLimits limits() const {
    return stages() == 1 ? sampling::SearchLimits{.tries_of_stage = 4, .turns_per_stage = 4}
                         : sampling::SearchLimits{.tries_of_stage = 2, .turns_per_stage = 36};
  }
  Prefix start(random::Stream& /*stream*/) const { return {}; }
  std::optional<Prefix> attempt(const Prefix& prefix, std::uint32_t stage,
                                sampling::SearchEffort& effort, random::Stream& stream) const;
  bool is_solution(const Prefix& prefix) const { return world_->satisfied(prefix.outcome); }
  const State& state_of(const Prefix& prefix) const { return prefix.state; }
  const Outcome& outcome_of(const Prefix& prefix) const { return prefix.outcome; }

 private:
  const UserScene* world_;
};

static_assert(sampling::StageBuilder<SceneSearch>);

}  // namespace sleight::worlds::user_scene
