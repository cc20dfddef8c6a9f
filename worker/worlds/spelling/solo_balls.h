// The spelling world's surrogate (surrogate_transition.h): each ball as if it fell alone into the
// box. Most balls meet no other one on their way, and where one falls alone hangs on its own drop
// and the box only, so a change of one ball takes the simulation of one.
//
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

/// Balls that are taken for granted: what they fill, and where they are dropped, by ball.
struct Anchor {
  Filling bins{};               ///< k_fills_none for the others; empty if nothing is known
  std::vector<Vec2> drops_m{};  ///< 0 for the others
};

class SoloBalls {
 public:
  using State = spelling::State;
  struct Outcome {
    /// False if an anchored ball differs, or if offsets leave an active ball no place to start.
    bool possible = true;
    Filling alone{};    ///< by ball: the bin that it fills alone
    Filling filling{};  ///< the same without second balls in a bin
    std::uint32_t filled = 0;
    /// Of the first ball whose simulation failed, of those that were simulated for this outcome;
    /// it is guessed to fill none.
    plan::FailurePointer failure{};
  };
  /// A failure leaves a guess, which is as good as any.
  static constexpr bool k_guesses_on_failure = true;

  /// A state in which an anchored ball is dropped elsewhere, or not at all, is not possible.
  SoloBalls(const Spelling& world, Anchor anchor) : world_(&world), anchor_(std::move(anchor)) {}

  State draw_prior(random::Stream& stream) const;
  double log_prior(const State& state) const;
  Outcome simulate(const State& state) const;
  /// Simulates the balls that differ, or all if a partition vertex does.
  Outcome simulate_from(const State& state, const State& from, const Outcome& of_from) const;
  double log_constraint(const Outcome& outcome) const;
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  /// A guess of the world's own starts: only a simulation counts them.
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
  /// Which bins are filled when anchored balls come first, and of others in one bin the first
  /// counts.
  void settle(Outcome& outcome) const;

  const Spelling* world_;
  Anchor anchor_;
};

static_assert(sampling::BoundsConstraint<SoloBalls>);
static_assert(sampling::ProposesByOutcome<SoloBalls>);
static_assert(sampling::SimulatesChanges<SoloBalls>);
static_assert(sampling::MayFail<SoloBalls>);

}  // namespace sleight::worlds::spelling
