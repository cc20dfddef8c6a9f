// The spelling world's surrogate (surrogate_transition.h): each ball as if it fell alone into the
// box. Most balls meet no other ball on their way. A lone ball's bin depends only on its drop and
// the box, so a change of one ball requires the simulation of one ball.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/plan/failure.h"
#include "common/random/stream.h"
#include "worker/sampling/target.h"
#include "worker/worlds/spelling/aimed_drops.h"
#include "worker/worlds/spelling/proposals.h"

namespace sleight::worlds::spelling {

class Spelling;

/// Balls that the surrogate treats as given: their bins and drops, by ball.
struct Anchor {
  Filling bins{};  ///< k_fills_none for balls outside the anchor; empty if nothing is known
  std::vector<Vec2> drops_m{};  ///< 0 for balls outside the anchor
};

class SoloBalls {
 public:
  using State = spelling::State;
  struct Outcome {
    /// False if an anchored ball differs, or if offsets leave no room for an active ball's start.
    bool possible = true;
    Filling alone{};    ///< by ball: the bin that it fills alone
    Filling filling{};  ///< same as `alone`, without second balls in a bin
    std::uint32_t filled = 0;
    /// Failure of the first failed ball among the balls simulated for this outcome. The guess for a
    /// failed ball is that it fills no bin.
    plan::FailurePointer failure{};
  };
  /// A failed simulation leaves a usable guess.
  static constexpr bool k_guesses_on_failure = true;

  /// A state is possible only if it drops each anchored ball at the anchored place.
  SoloBalls(const Spelling& world, Anchor anchor) : world_(&world), anchor_(std::move(anchor)) {}

  State draw_prior(random::Stream& stream) const;
  double log_prior(const State& state) const;
  Outcome simulate(const State& state) const;
  /// Simulates the balls that differ, or all balls if a partition vertex differs.
  Outcome simulate_from(const State& state, const State& from, const Outcome& of_from) const;
  double log_constraint(const Outcome& outcome) const;
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  /// Returns false: only a real simulation counts overlapping starts.
  bool starts_overlap(const Outcome& /*outcome*/) const { return false; }
  double log_constraint_at_most(const State& state) const;
  bool satisfied(const Outcome& outcome) const;
  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const;
  sampling::Proposal<State> propose(const State& state, std::span<const double> scales,
                                    random::Stream& stream) const;
  sampling::Proposal<State> propose(const State& state, const Outcome& outcome,
                                    std::span<const double> scales, random::Stream& stream) const;
  double log_q_ratio(const State& state, const Outcome& outcome,
                     const sampling::Proposal<State>& proposal,
                     const Outcome& candidate_outcome) const;
  bool has_scale(std::uint32_t kind) const;
  std::uint32_t proposal_kinds() const;

 private:
  bool leaves_anchored(const State& state) const;
  /// Computes which bins are filled: anchored balls come first, then the first of the other balls
  /// in each bin.
  void settle(Outcome& outcome) const;

  const Spelling* world_;
  Anchor anchor_;
};

static_assert(sampling::BoundsConstraint<SoloBalls>);
static_assert(sampling::ProposesByOutcome<SoloBalls>);
static_assert(sampling::SimulatesChanges<SoloBalls>);
static_assert(sampling::MayFail<SoloBalls>);

}  // namespace sleight::worlds::spelling
