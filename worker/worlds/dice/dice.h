// The world of dice on a random table (thesis 2.4.4): which tables and throws bring dice to rest as
// the goals demand?
//
//   `random variables`: the table's control points (random_table.h), and each die's start (state.h)
//     except fixed components.
//   `log p_w`: see state.h.
//   `outcome`: the dice at the end (at rest or at the time limit), and the dice at the times of the
//     goals.
//   `log p_c`: at most 0 (goals.h); -infinity if there is no simulation.
//   `satisfied`: all goals are met, and all dice rest.
//   `proposal`: see proposals.h.
//
// One simulation contains all dice of a throw, so dice can collide with each other. Every tenth of
// a second, the simulation tests whether all dice are at rest.
//
// Invariants
//   1. An animation is a function of the state and the parameters.
//   2. `simulate_from` returns the same bits as `simulate`, except for Outcome::history.
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

namespace sleight::worlds::dice {

/// Number of bins in a histogram of control points' heights. Heights are in standard deviations.
/// The first bin is below k_offset_first_sd. Further bins have width k_offset_step_sd. The last bin
/// has all greater heights.
inline constexpr std::size_t k_offset_bins = 14;
inline constexpr double k_offset_first_sd = -3;
inline constexpr double k_offset_step_sd = 0.5;
/// Returns the number of a standard score's bin.
std::size_t offset_bin_of(double score);

enum class End : std::uint8_t {
  settled,     ///< all dice at rest
  time_limit,  ///< a die moved until the time limit
  impossible,  ///< dice start overlapping each other or the table
  failed       ///< the simulator failed: no sample
};

struct Outcome {
  End end = End::settled;
  double end_s = 0;              ///< when the last die came to rest, or the time limit
  Judgement judgement{};         ///< empty if there is no animation
  ContactShares contacts{};      ///< weights of the table's control points in collisions
  std::uint32_t collisions = 0;  ///< collisions of dice with the table
  /// Normalised log p_w of the control points that influenced collisions. This log p_w tells how
  /// plausible the visible part of the table is.
  double log_plausibility = 0;
  /// For these control points: a histogram of heights, and the sum of squared heights, both in
  /// standard deviations. Zero if heights aren't random.
  std::array<std::uint32_t, k_offset_bins> offsets{};
  double offset_squares = 0;
  std::vector<DieView> at_end{};   ///< unnumbered; the judgement has numberings
  plan::FailurePointer failure{};  ///< reason if End is failed
  /// `simulate_from` uses this history, and also creates histories. Null if no history was
  /// requested, or if simulate_from's candidate had nothing in common with its state.
  std::shared_ptr<const physics::History> history{};

  bool is_animation() const { return end == End::settled || end == End::time_limit; }
};

/// A simulation's outcome, and the views that goals judge. Views are empty if there is no
/// animation.
struct ViewedOutcome {
  Outcome outcome;
  Views views;
};

/// A simulation's outcome and motion. The recording is empty if there is no animation.
struct Animation {
  Outcome outcome;
  physics::Recording recording;
};

class Dice {
 public:
  using State = dice::State;
  using Outcome = dice::Outcome;

  explicit Dice(const Parameters& parameters);

  const Parameters& parameters() const { return parameters_; }
  std::size_t dice() const { return parameters_.world.dice.size(); }

  State draw_prior(random::Stream& stream) const { return draw_state(parameters_.world, stream); }
  double log_prior(const State& state) const { return log_density_of(parameters_.world, state); }
  Outcome simulate(const State& state) const;
  ViewedOutcome simulate_and_view(const State& state) const;
  /// Returns the signed misses of all goals (goals.h). REQUIRES: the views are of an animation of
  /// this world.
  std::vector<Miss> signed_misses(const Views& views) const {
    return dice::signed_misses(parameters_.goals, views, times_s_);
  }
  /// Simulates a candidate. If the candidate resembles `state`, the simulation reuses the outcome's
  /// history and is faster.
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome) const;
  double log_constraint(const Outcome& outcome) const;
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  bool starts_overlap(const Outcome& outcome) const { return outcome.end == End::impossible; }
  /// Returns 0, because goals never increase log p_c.
  double log_constraint_at_most(const State& /*state*/) const { return 0; }
  bool satisfied(const Outcome& outcome) const {
    return outcome.end == End::settled && outcome.judgement.all_met;
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

  /// Returns values in the order of the archive layout's outcomes. Distances are NaN if there is no
  /// simulation.
  std::vector<double> outcome_values(const Outcome& outcome) const;

  /// Returns the physics scene; its bodies are the dice.
  physics::Scene scene(const State& state) const;
  Animation animate(const State& state) const;

 private:
  struct Wanted {
    bool history = false;  ///< stored in the outcome
    physics::Recording* recording = nullptr;
    Views* views = nullptr;
  };
  Outcome simulated(const State& state, const Wanted& wanted,
                    const std::shared_ptr<const physics::History>& history) const;
  void look_at_contacts(const State& state, const physics::Scene& scene,
                        std::span<const physics::SurfaceTouch> touches, Outcome& outcome) const;

  Parameters parameters_;
  std::vector<double> times_s_;  ///< times of the goals
  std::shared_ptr<const physics::Compound> cube_;
};

static_assert(sampling::BoundsConstraint<Dice>);
static_assert(sampling::MayFail<Dice>);
static_assert(sampling::ProposesByOutcome<Dice>);
static_assert(sampling::SimulatesChanges<Dice>);

}  // namespace sleight::worlds::dice
