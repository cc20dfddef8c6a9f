// The world of dice on a random table (thesis 2.4.4): which table, and which throws, make dice come
// to rest as is wanted?
//
//   random variables  the table's control points (random_table.h); of each die's start those
//                     components that are not fixed (state.h)
//   log p_w           as in state.h
//   outcome           the dice at rest, or at the time limit, and at the times that goals look at
//   log p_c           as in goals.h; at most 0; -infinity if there is no simulation
//   satisfied         all goals are met, and all dice rest
//   proposal          proposals.h
//
// All dice of a throw meet each other: one simulation has them all. It is looked at each tenth of a
// second whether all are at rest.
//
// Invariants
//   1. An animation is a function of the state and the parameters.
//   2. simulate_from gives, bit for bit, what simulate does, but for what serves to go on from it.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/base/bytes.h"
#include "common/plan/failure.h"
#include "common/random/stream.h"
#include "worker/physics/contact/surface_touches.h"
#include "worker/physics/reuse/history.h"
#include "worker/physics/reuse/recording.h"
#include "worker/physics/scene/scene.h"
#include "worker/sampling/target.h"
#include "worker/worlds/dice/parameters.h"
#include "worker/worlds/dice/proposals.h"
#include "worker/worlds/dice/state.h"
#include "worker/worlds/dice/state_bytes.h"

namespace sleight::worlds::dice {

/// Heights of control points are counted by how many standard deviations they are high: below
/// k_offset_first_sd, in steps of k_offset_step_sd from there, and above the last of these.
inline constexpr std::size_t k_offset_bins = 14;
inline constexpr double k_offset_first_sd = -3;
inline constexpr double k_offset_step_sd = 0.5;
/// The bin of a standard score.
std::size_t offset_bin_of(double score);

/// How a simulation ended.
enum class End : std::uint8_t {
  settled,     ///< all dice at rest
  time_limit,  ///< some die moved for too long
  impossible,  ///< dice start in one place or in the table
  failed       ///< the simulator could not go on: no sample
};

struct Outcome {
  End end = End::settled;
  double end_s = 0;              ///< when the last die came to rest, or the limit
  Judgement judgement{};         ///< empty if there is no animation
  ContactShares contacts{};      ///< of the table's control points
  std::uint32_t collisions = 0;  ///< of dice with the table
  /// log p_w of the control points that collisions hung on, normalised: how plausible what one sees
  /// of the table is.
  double log_plausibility = 0;
  /// How many of these have which height, and the sum of their heights' squares, in standard
  /// deviations; nothing where heights are not random.
  std::array<std::uint32_t, k_offset_bins> offsets{};
  double offset_squares = 0;
  std::vector<DieView> at_end{};   ///< unnumbered; the judgement has numberings
  plan::FailurePointer failure{};  ///< why it failed
  /// For simulate_from, which makes it; none if that is not wanted, or the candidate had nothing in
  /// common with the state.
  std::shared_ptr<const physics::History> history{};

  bool is_animation() const { return end == End::settled || end == End::time_limit; }
};

/// What a simulation came to, and what goals look at; empty if there is no animation.
struct ViewedOutcome {
  Outcome outcome;
  Views views;
};

/// A simulation with its motion, which is empty if there is no animation.
struct Animation {
  Outcome outcome;
  physics::Recording recording;
};

/// Whether simulations are made from what is known of similar ones. Changes no result.
enum class Replays : std::uint8_t { no, yes };

class Dice {
 public:
  using State = dice::State;
  using Outcome = dice::Outcome;

  explicit Dice(const Parameters& parameters, Replays replays = Replays::yes);

  const Parameters& parameters() const { return parameters_; }
  std::size_t dice() const { return parameters_.world.dice.size(); }

  State draw_prior(random::Stream& stream) const { return draw_state(parameters_.world, stream); }
  double log_prior(const State& state) const { return log_density_of(parameters_.world, state); }
  Outcome simulate(const State& state) const;
  /// The same with what goals look at.
  ViewedOutcome simulate_and_view(const State& state) const;
  /// Of all goals (goals.h). REQUIRES: views of an animation of this world.
  std::vector<Miss> signed_misses(const Views& views) const {
    return dice::signed_misses(parameters_.goals, views, times_s_);
  }
  /// The same of a candidate, for less, if it resembles a state whose outcome is known.
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome) const;
  double log_constraint(const Outcome& outcome) const;
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  bool starts_overlap(const Outcome& outcome) const { return outcome.end == End::impossible; }
  /// Goals can only be missed.
  double log_constraint_at_most(const State& /*state*/) const { return 0; }
  bool satisfied(const Outcome& outcome) const {
    return outcome.end == End::settled && outcome.judgement.all_met;
  }
  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const {
    return propose(state, std::span<const double>{}, stream);
  }
  /// Without change_contact's collisions: it proposes the present state.
  sampling::Proposal<State> propose(const State& state, std::span<const double> scales,
                                    random::Stream& stream) const {
    return dice::propose(parameters_, state, {}, scales, stream);
  }
  sampling::Proposal<State> propose(const State& state, const Outcome& outcome,
                                    std::span<const double> scales, random::Stream& stream) const {
    return dice::propose(parameters_, state, outcome.contacts, scales, stream);
  }
  double log_q_ratio(const State& state, const Outcome& outcome,
                     const sampling::Proposal<State>& proposal,
                     const Outcome& candidate_outcome) const {
    return contact_log_q_ratio(state, outcome.contacts, proposal.candidate,
                               candidate_outcome.contacts);
  }
  bool has_scale(std::uint32_t kind) const { return dice::has_scale(static_cast<Kind>(kind)); }
  std::uint32_t proposal_kinds() const { return k_kinds; }

  base::Bytes encode(const State& state) const { return dice::encode(state); }
  std::optional<State> decode(base::BytesView bytes) const {
    return dice::decode(parameters_.world, bytes);
  }
  std::size_t owned_bytes(const State& state, const Outcome& outcome) const;

  /// In the order of the archive layout's outcomes; distances are NaN if there is no simulation.
  std::vector<double> outcome_values(const Outcome& outcome) const;

  /// The simulation's scene; its bodies are the dice.
  physics::Scene scene(const State& state) const;
  /// What simulate(state) gives, and the motion.
  Animation animate(const State& state) const;

 private:
  /// What else is wanted of a simulation.
  struct Wanted {
    bool history = false;  ///< in the outcome
    physics::Recording* recording = nullptr;
    Views* views = nullptr;
  };
  Outcome simulated(const State& state, const Wanted& wanted,
                    const std::shared_ptr<const physics::History>& history) const;
  void look_at_contacts(const State& state, const physics::Scene& scene,
                        std::span<const physics::SurfaceTouch> touches, Outcome& outcome) const;

  Parameters parameters_;
  Replays replays_;
  std::vector<double> times_s_;  ///< that goals look at
  std::shared_ptr<const physics::Compound> cube_;
};

static_assert(sampling::BoundsConstraint<Dice>);
static_assert(sampling::MayFail<Dice>);
static_assert(sampling::ProposesByOutcome<Dice>);
static_assert(sampling::SimulatesChanges<Dice>);

}  // namespace sleight::worlds::dice
