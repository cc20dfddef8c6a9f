// The world of a user's scene: which of its uncertain values make it end as requested?
//
//   `random variables`: a vector of standard normals and uniforms (quantities.h), and the noise of
//     impacts (state.h).
//   `outcome`: how the simulation ended, and the constraints' distances (constraints.h).
//   `log p_c`: at most 0; -infinity if a start is impossible (End).
//   `satisfied`: all constraints are met.
//   `proposal`: see moves.h.
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
#include "worker/sampling/splitting.h"
#include "worker/sampling/stage_search.h"
#include "worker/sampling/target.h"
#include "worker/worlds/user_scene/judge.h"
#include "worker/worlds/user_scene/moves.h"
#include "worker/worlds/user_scene/parameters.h"
#include "worker/worlds/user_scene/state.h"

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
  Judgement judgement{};                  ///< empty if there is no animation
  std::vector<physics::Impact> noised{};  ///< in order
  /// The state's standard normals that the simulation used: their number, and the sum of squares.
  std::uint32_t normals = 0;
  double squares = 0;
  plan::FailurePointer failure{};
  /// Used by simulate_from; null if no history was requested.
  std::shared_ptr<const physics::History> history{};

  bool is_animation() const { return end == End::settled || end == End::time_limit; }
};

struct Animation {
  Outcome outcome;
  physics::Recording recording;
};

class SceneSearch;

class UserScene {
 public:
  using State = user_scene::State;
  using Outcome = user_scene::Outcome;
  struct Guide {};

  explicit UserScene(const Parameters& parameters);

  const Parameters& parameters() const { return model_->parameters; }
  const Quantities& quantities() const { return model_->quantities; }

  const Judge& judge() const { return model_->judge; }
  bool has_noise() const { return model_->parameters.scene.has_noise(); }

  State draw_prior(random::Stream& stream) const;
  double log_prior(const State& state) const { return log_density(quantities(), state); }
  Outcome simulate(const State& state) const { return simulated(state, {}, {}); }
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome) const {
    return simulate_from(candidate, state, outcome, Wanted{});
  }
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
  /// Without an outcome, a shot knows no impacts, so it proposes the present state.
  sampling::Proposal<State> propose(const State& state, std::span<const double> scales,
                                    random::Stream& stream) const {
    return propose(state, {}, scales, stream);
  }
  sampling::Proposal<State> propose(const State& state, const Outcome& outcome,
                                    std::span<const double> scales, random::Stream& stream) const;
  double log_q_ratio(const State& state, const Outcome& outcome,
                     const sampling::Proposal<State>& proposal,
                     const Outcome& candidate_outcome) const;
  bool has_scale(std::uint32_t kind) const {
    return static_cast<Kind>(kind) >= Kind::step_all && static_cast<Kind>(kind) != Kind::tail;
  }
  std::uint32_t proposal_kinds() const {
    return has_noise() ? k_move_kinds : k_move_kinds_without_noise;
  }

  base::Bytes encode(const State& state) const { return user_scene::encode(state, has_noise()); }
  std::optional<State> decode(base::BytesView bytes) const {
    return user_scene::decode(quantities(), has_noise(), bytes);
  }
  std::size_t owned_bytes(const State& state, const Outcome& outcome) const;
  /// Returns values in the order of the archive layout's outcomes; distances are NaN without an
  /// animation.
  std::vector<double> outcome_values(const Outcome& outcome) const;

  Animation animate(const State& state) const;

  // Stages: constraints that are decided together (judge.h).
  std::uint32_t stages() const { return static_cast<std::uint32_t>(judge().stages().size()); }
  sampling::Progress progress(const Outcome& outcome) const;
  /// Keeps the history. Replays the history of `earlier`, if it has one.
  Outcome simulate_stages(const State& state, std::uint32_t stages, const Outcome& earlier) const {
    return simulated(state, {.history = true, .stages = stages}, earlier.history);
  }
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome,
                        std::uint32_t stages) const {
    return simulate_from(candidate, state, outcome, {.stages = stages, .stops_early = true});
  }

  // The search.
  Guide learn(std::uint64_t /*seed*/) const { return {}; }
  std::span<const plan::FailurePointer> failures_of(const Guide& /*guide*/) const { return {}; }
  SceneSearch builder(const Guide& guide) const;
  Outcome simulate_to_rest(const State& state) const { return simulate(state); }
  std::string stage_name(std::uint32_t stage) const;
  /// The constraints, the last one first: a try that first fails at a later one is nearer.
  std::vector<sampling::MissKind> miss_kinds() const;
  /// Returns what an outcome missed first, by constraint. Empty: nothing that has a distance.
  std::optional<sampling::Miss> first_miss(const Outcome& outcome) const;
  std::string search_advice() const {
    return "`sleight scene check` shows how often draws from the prior meet each constraint.";
  }
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
    std::uint32_t stages = ~0U;  ///< at most; the simulation ends when they can be judged
    bool stops_early = false;    ///< ends at the first stage that isn't passed
  };
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome,
                        const Wanted& asked) const;
  Outcome simulated(const State& state, const Wanted& wanted,
                    const std::shared_ptr<const physics::History>& history) const;
  void count_normals(const State& state, Outcome& outcome) const;

  std::shared_ptr<const Model> model_;
};

static_assert(sampling::BoundsConstraint<UserScene>);
static_assert(sampling::MayFail<UserScene>);
static_assert(sampling::ProposesByOutcome<UserScene>);
static_assert(sampling::SimulatesChanges<UserScene>);
static_assert(sampling::PassesStages<UserScene>);

}  // namespace sleight::worlds::user_scene
