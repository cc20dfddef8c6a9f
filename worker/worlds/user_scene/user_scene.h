// The world of a user's scene: which of its uncertain values make it end as requested?
//
//   `random variables`: a vector of standard normals and uniforms (quantities.h).
//   `outcome`: how the simulation ended, and the constraints' distances (constraints.h).
//   `log p_c`: at most 0; -infinity if a start is impossible (End).
//   `satisfied`: all constraints are met.
//   `proposal`: moves that keep the prior invariant, on a block of numbers: one draw, all draws of
//     one body, or all. A step mixes old and new numbers: z' = sqrt(1 - s^2) z + s xi for normals,
//     and a reflected normal step of size s / 2 for uniforms. A redraw draws the block afresh.
//
// A simulation ends when the last constraint has looked; if one looks at bodies at rest, when all
// bodies have ended (end_watch.h), but at the latest at end_s. Kept takes end there too.
//
// Invariants
//   1. An animation is a function of the state and the parameters.
//   2. `simulate_from` returns the same bits as `simulate`, except for Outcome::history.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/plan/failure.h"
#include "common/random/stream.h"
#include "worker/physics/reuse/history.h"
#include "worker/physics/reuse/recording.h"
#include "worker/sampling/burn_in_judge.h"
#include "worker/sampling/stage_search.h"
#include "worker/sampling/target.h"
#include "worker/worlds/user_scene/judge.h"
#include "worker/worlds/user_scene/parameters.h"

namespace sleight::worlds::user_scene {

/// Maximum collisions of a simulation. A simulation with more has failed.
inline constexpr std::size_t k_collisions_max = 300'000;

enum class End : std::uint8_t {
  settled,     ///< all bodies rest or have left, or no constraint waits for this
  time_limit,  ///< a body still moved at end_s
  impossible,  ///< bodies overlap where one starts, one can't rest there, or a box is too flat
  failed       ///< the simulator failed: no sample
};

struct Outcome {
  End end = End::settled;
  double end_s = 0;
  std::uint32_t collisions = 0;
  Judgement judgement{};  ///< empty if there is no animation
  plan::FailurePointer failure{};
  /// Used by simulate_from; null if no history was requested.
  std::shared_ptr<const physics::History> history{};

  bool is_animation() const { return end == End::settled || end == End::time_limit; }
};

struct Animation {
  Outcome outcome;
  physics::Recording recording;
};

/// The kinds of proposals, in this order. Steps have a scale.
enum class Kind : std::uint8_t {
  redraw_all,
  redraw_body,
  redraw_draw,
  step_all,
  step_body,
  step_draw
};
inline constexpr std::uint32_t k_kinds = 6;

class SceneSearch;

class UserScene {
 public:
  using State = Numbers;
  using Outcome = user_scene::Outcome;
  struct Guide {};

  explicit UserScene(const Parameters& parameters);

  const Parameters& parameters() const { return model_->parameters; }
  const Quantities& quantities() const { return model_->quantities; }

  State draw_prior(random::Stream& stream) const { return quantities().draw_prior(stream); }
  double log_prior(const State& state) const { return quantities().log_density(state); }
  Outcome simulate(const State& state) const { return simulated(state, {}, nullptr); }
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome) const;
  double log_constraint(const Outcome& outcome) const;
  double log_constraint_at_most(const State& /*state*/) const { return 0; }
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  bool starts_overlap(const Outcome& outcome) const { return outcome.end == End::impossible; }
  bool satisfied(const Outcome& outcome) const {
    return outcome.is_animation() && outcome.judgement.all_met;
  }
  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const {
    return propose(state, std::span<const double>{}, stream);
  }
  sampling::Proposal<State> propose(const State& state, std::span<const double> scales,
                                    random::Stream& stream) const;
  bool has_scale(std::uint32_t kind) const { return static_cast<Kind>(kind) >= Kind::step_all; }
  std::uint32_t proposal_kinds() const { return k_kinds; }

  base::Bytes encode(const State& state) const;
  /// Refuses a wrong length, numbers that aren't finite, and uniforms outside (0, 1).
  std::optional<State> decode(base::BytesView bytes) const;
  std::size_t owned_bytes(const State& state, const Outcome& outcome) const;
  /// Returns values in the order of the archive layout's outcomes; distances are NaN without an
  /// animation.
  std::vector<double> outcome_values(const Outcome& outcome) const;

  Animation animate(const State& state) const;

  // The search.
  Guide learn(std::uint64_t /*seed*/) const { return {}; }
  std::span<const plan::FailurePointer> failures_of(const Guide& /*guide*/) const { return {}; }
  SceneSearch builder(const Guide& guide) const;
  Outcome simulate_to_rest(const State& state) const { return simulate(state); }
  std::uint32_t stages() const { return 1; }
  std::string stage_name(std::uint32_t /*stage*/) const { return "all constraints"; }
  std::vector<sampling::BurnInValue> burn_in_values() const {
    return {{.name = "log_prior"}, {.name = "log_constraint"}};
  }
  std::vector<double> burn_in_values_of(const State& state, const Outcome& outcome) const {
    return {log_prior(state), log_constraint(outcome)};
  }

 private:
  /// Shared by copies of the world.
  struct Model {
    explicit Model(const Parameters& given)
        : parameters(given),
          quantities(parameters.scene, *parameters.built, parameters.uncertain),
          judge(parameters.scene, *parameters.built, parameters.constraints) {}
    Parameters parameters;
    Quantities quantities;
    Judge judge;
  };
  struct Wanted {
    bool history = false;  ///< stored in the outcome
    physics::Recording* recording = nullptr;
  };
  Outcome simulated(const State& state, const Wanted& wanted,
                    const std::shared_ptr<const physics::History>& history) const;
  /// Calls `act` for each number of a random block: one draw, a body's draws, or all.
  template <class Act>
  void for_block(Kind kind, random::Stream& stream, Act act) const;

  std::shared_ptr<const Model> model_;
};

static_assert(sampling::BoundsConstraint<UserScene>);
static_assert(sampling::MayFail<UserScene>);
static_assert(sampling::ScalesProposals<UserScene>);
static_assert(sampling::SimulatesChanges<UserScene>);

/// Search: some draws from the prior, then an annealed walk from the best of them, until all
/// constraints are met.
class SceneSearch {
 public:
  struct Prefix {
    Numbers state;
    Outcome outcome;
  };

  /// REQUIRES: the world outlives the search.
  explicit SceneSearch(const UserScene& world) : world_(&world) {}

  std::uint32_t stages() const { return 1; }
  sampling::SearchLimits limits() const { return {.tries_of_stage = 4, .turns_per_stage = 4}; }
  Prefix start(random::Stream& /*stream*/) const { return {}; }
  std::optional<Prefix> attempt(const Prefix& prefix, std::uint32_t stage,
                                sampling::SearchEffort& effort, random::Stream& stream) const;
  bool is_solution(const Prefix& prefix) const { return world_->satisfied(prefix.outcome); }
  const Numbers& state_of(const Prefix& prefix) const { return prefix.state; }
  const Outcome& outcome_of(const Prefix& prefix) const { return prefix.outcome; }

 private:
  const UserScene* world_;
};

static_assert(sampling::StageBuilder<SceneSearch>);

}  // namespace sleight::worlds::user_scene
