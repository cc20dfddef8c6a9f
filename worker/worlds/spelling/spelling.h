// The world of the balls that spell (thesis 2.4.3, A.2): which boxes and drops bring balls to rest
// in designated bins?
//
//   `random variables`: offsets of the partition vertices, which balls are active, and where active
//     balls are dropped.
//   `log p_w`: each offset coordinate is N(0, vertex_sd), a ball is active with probability 1/2,
//     and drop places are uniform.
//   `outcome`: k, the number of filled designated bins. A ball fills a bin if its centre is in the
//     bin, below the partitions' height, at rest or trapped (traps.h).
//   `log p_c`: k log lambda; -infinity if there is no simulation.
//   `satisfied`: all designated bins are filled, and no active ball is elsewhere.
//   `proposal`: A.2.2 with corrected ratios (proposals.h).
//
// There are as many balls as designated bins. Ball i is dropped from rest after i drop intervals;
// an inactive ball leaves a gap. The box stands on the ground. A ball counts as elsewhere if it
// leaves the box, or if it still moves at the time limit and isn't trapped.
//
// Deciding early. A trapped ball isn't simulated further until another ball comes near. When all
// balls are trapped or at rest, the outcome is decided. A decided outcome equals the outcome of the
// whole simulation, which simulate_to_rest() runs.
//
// Invariants
//   1. An animation is a function of the state and the parameters.
//   2. A decision made early equals the result of a simulation to rest, unless that simulation
//      fails. A simulation fails if it has far more events than usual, for example because a ball
//      is wedged. A simulation to rest has more events.
//   3. With Kernel::thesis, draws and ratios are as printed in A.2.2. Then a target's invariants 1
//      and 2 (target.h) don't hold, and Algorithm 2.1 has another distribution.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/plan/failure.h"
#include "common/random/stream.h"
#include "worker/physics/reuse/recording.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/simulator/simulation.h"
#include "worker/sampling/target.h"
#include "worker/worlds/spelling/aimed_drops.h"
#include "worker/worlds/spelling/bins.h"
#include "worker/worlds/spelling/box_geometry.h"
#include "worker/worlds/spelling/parameters.h"
#include "worker/worlds/spelling/proposals.h"
#include "worker/worlds/spelling/solo_balls.h"
#include "worker/worlds/spelling/spelling_history.h"

namespace sleight::worlds::spelling {

enum class End : std::uint8_t {
  settled,     ///< every ball is at rest or trapped in its bin
  time_limit,  ///< a ball moved until the time limit
  impossible,  ///< two balls overlap at their start, or offsets turn the box inside out
  failed       ///< the simulator failed or took too many events: no sample
};

struct Outcome {
  std::uint32_t filled = 0;     ///< designated bins with a ball that stays there
  std::uint32_t elsewhere = 0;  ///< active balls that fill no bin, including second balls in a bin
  /// Time of the decision. After the last drop, the simulation tests every tenth of a second
  /// whether the outcome is decided.
  double end_s = 0;
  End end = End::settled;
  Filling filling{};               ///< empty if there is no animation
  plan::FailurePointer failure{};  ///< reason if End is failed
  /// `simulate_from` uses this history, and also creates histories. Null if no history was
  /// requested, or if simulate_from's candidate had nothing in common with its state.
  std::shared_ptr<const SpellingHistory> history{};

  bool is_animation() const { return end == End::settled || end == End::time_limit; }
};

/// A whole animation, simulated to rest or to the time limit.
struct Animation {
  physics::Recording recording;        ///< of the active balls only
  std::vector<std::uint32_t> balls{};  ///< the balls' numbers, in the recording's order
};

/// Whether simulations reuse the histories of similar simulations. Changes no result.
enum class Replays : std::uint8_t { no, yes };

class Spelling {
 public:
  using State = spelling::State;
  using Outcome = spelling::Outcome;

  explicit Spelling(const Parameters& parameters, Replays replays = Replays::yes);

  const Parameters& parameters() const { return parameters_; }
  const Bins& bins() const { return bins_; }
  const Prior& prior() const { return prior_; }
  std::uint32_t balls() const { return prior_.balls; }
  /// The window of each designated bin, for aimed drops. Bins are in the pattern's order, from the
  /// lowest y.
  const Windows& windows() const { return windows_; }
  /// Middle of a designated bin. REQUIRES: number < balls().
  const Vec2& middle_m(std::size_t number) const { return middles_m_[number]; }
  /// Returns the number of the designated bin below a place. If there is no such bin, returns
  /// k_fills_none.
  std::int16_t number_below(const Vec2& place_m) const;

  State draw_prior(random::Stream& stream) const {
    return draw_state(prior_, parameters_.proposal.kernel, stream);
  }
  /// Draws a box from the prior, and a drop for every ball.
  State draw_throw(random::Stream& stream) const;
  double log_prior(const State& state) const { return prior_.log_density(state); }
  /// Simulates until the outcome is decided.
  Outcome simulate(const State& state) const;
  /// Simulates a candidate. If the candidate resembles `state`, the simulation reuses the outcome's
  /// history and is faster.
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome) const;
  /// Simulates until all balls are at rest. Returns the same outcome as `simulate` except for
  /// `end_s`.
  Outcome simulate_to_rest(const State& state) const;
  double log_constraint(const Outcome& outcome) const;
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  bool starts_overlap(const Outcome& outcome) const { return outcome.end == End::impossible; }
  /// Each active ball fills at most one bin.
  double log_constraint_at_most(const State& state) const {
    return std::max(0.0, state.active_count() * parameters_.constraint.log_lambda);
  }
  bool satisfied(const Outcome& outcome) const;
  /// Proposes all kinds, including the kinds that depend on the outcome (aimed_drops.h).
  sampling::Proposal<State> propose(const State& state, const Outcome& outcome,
                                    std::span<const double> scales, random::Stream& stream) const {
    return propose(state, outcome.is_animation() ? &outcome.filling : nullptr, scales, stream);
  }
  double log_q_ratio(const State& state, const Outcome& outcome,
                     const sampling::Proposal<State>& proposal,
                     const Outcome& candidate_outcome) const {
    return log_q_ratio(state, outcome.is_animation() ? &outcome.filling : nullptr, proposal,
                       candidate_outcome.is_animation() ? &candidate_outcome.filling : nullptr);
  }
  /// Makes a proposal from a filling that a simulation or a surrogate computed. Null: no filling.
  sampling::Proposal<State> propose(const State& state, const Filling* filling,
                                    std::span<const double> scales, random::Stream& stream) const;
  double log_q_ratio(const State& state, const Filling* filling,
                     const sampling::Proposal<State>& proposal,
                     const Filling* candidate_filling) const;

  // The surrogate simulates each ball alone (solo_balls.h). Only the full simulation finds helped
  // balls.
  using Surrogate = SoloBalls;
  using Anchor = spelling::Anchor;
  SoloBalls surrogate(const Anchor& anchor) const { return SoloBalls(*this, anchor); }
  Anchor draw_anchor(const State& state, const Outcome& outcome, const SoloBalls::Outcome& solo,
                     double keep, random::Stream& stream) const;
  double log_anchor_probability(const Anchor& anchor, const Outcome& outcome,
                                const SoloBalls::Outcome& solo, double keep) const;
  sampling::SurrogateSteps surrogate_steps(std::span<const double> scales) const;
  struct Alone {
    bool possible = true;             ///< the offsets leave a valid box and room for the start
    std::int16_t bin = k_fills_none;  ///< the number of the designated bin that it fills
    plan::FailurePointer failure{};   ///< if set, nothing is known and `bin` is k_fills_none
  };
  Alone fall_alone(std::span<const Vec3> offsets_m, const Vec2& drop_m) const;

  bool has_scale(std::uint32_t kind) const { return spelling::has_scale(static_cast<Kind>(kind)); }
  std::uint32_t proposal_kinds() const { return k_kinds; }

  base::Bytes encode(const State& state) const { return spelling::encode(state); }
  /// Bytes of the state's and the outcome's arrays. The surrogate's outcome may be stored with the
  /// sample, so its two arrays count too. These arrays have an entry for each ball.
  std::size_t owned_bytes(const State& state, const Outcome& outcome) const {
    return state.offsets_m.capacity() * sizeof(Vec3) + state.active.capacity() +
           state.drops_m.capacity() * sizeof(Vec2) +
           (outcome.filling.capacity() + 2 * state.active.size()) * sizeof(Filling::value_type) +
           (outcome.history ? outcome.history->bytes() : 0);
  }
  std::optional<State> decode(base::BytesView bytes) const {
    return spelling::decode(prior_, bytes);
  }
  /// Returns the values in the order of the archive layout's outcomes.
  std::vector<double> outcome_values(const Outcome& outcome) const;

  /// Returns the physics scene; its bodies are the active balls in ascending order. Returns nothing
  /// if the offsets turn the box inside out.
  std::optional<physics::Scene> scene(const State& state) const;
  /// REQUIRES: simulate_to_rest(state) is an animation.
  Animation animate(const State& state) const;
  /// By bin, row by row from the lowest y: the number of the ball that fills the designated bin, or
  /// -1. Bins count as in simulate().
  std::vector<int> balls_of_bins(const State& state) const;
  struct Staying {
    std::uint32_t ball = 0;
    Vec3 centre_m = Vec3::Zero();
  };
  /// Returns the outcome of balls that stay where they are. `others` further balls fill no bin.
  Outcome judged(std::span<const Staying> staying, std::uint32_t others) const;

 private:
  /// Runs until all balls stay, or until the time limit. Returns an error if the simulator fails.
  template <class Engine, class AllStay>
  std::optional<physics::SceneError> run(physics::Tick last_start, Engine& engine,
                                         const AllStay& all_stay) const;
  physics::Tick limit_after(physics::Tick last_start) const;
  physics::Tick start_of(std::size_t ball) const;
  enum class Until : std::uint8_t { decided, rest };
  struct Known {
    const State& state;
    const SpellingHistory& history;
  };
  Outcome simulated(const State& state, Until until, bool records = false,
                    const Known* known = nullptr) const;
  /// Returns nothing if the history doesn't suffice.
  std::optional<Outcome> simulated_in(BoxGeometry& geometry, const State& state, Until until,
                                      bool records, const Known* known) const;
  /// Returns the outcome without its end time. `balls` are the balls as observed at the end.
  Outcome came_to(const State& state, std::span<const Traps::Ball> balls, const Traps& traps) const;
  static Outcome stopped(const physics::SceneError& error, const State& state);
  /// Returns a state's physics scene. Bodies::all contains all balls; inactive balls never start.
  enum class Bodies : std::uint8_t { active, all };
  physics::Scene scene_in(const State& state, std::shared_ptr<const physics::TriangleMesh> surface,
                          Bodies bodies) const;
  std::unique_ptr<BoxGeometry> new_geometry() const;

  Parameters parameters_;
  Replays replays_ = Replays::yes;
  Bins bins_;
  Influence influence_;
  Prior prior_;
  Windows windows_;
  std::vector<Vec2> middles_m_;        ///< of designated bins
  std::vector<std::int16_t> numbers_;  ///< by bin; k_fills_none if not designated
  std::unique_ptr<BoxGeometries> geometries_ = std::make_unique<BoxGeometries>();
};

static_assert(sampling::BoundsConstraint<Spelling>);
static_assert(sampling::ProposesByOutcome<Spelling>);
static_assert(sampling::HasSurrogate<Spelling>);
static_assert(sampling::MayFail<Spelling>);
static_assert(sampling::SimulatesChanges<Spelling>);

}  // namespace sleight::worlds::spelling
