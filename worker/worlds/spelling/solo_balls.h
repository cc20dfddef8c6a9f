// The spelling world's surrogate (surrogate_transition.h). The surrogate simulates each ball as if
// the ball fell alone into the box. Most balls meet no other ball on their way. A lone ball's bin
// depends only on its drop and the box. So if one ball changes, only one ball must be simulated.
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

/// The surrogate treats these balls as given. Bins and drops are by ball.
struct Anchor {
  Filling bins{};  ///< k_fills_none for balls outside the anchor; empty if nothing is known
  std::vector<Vec2> drops_m{};  ///< 0 for balls outside the anchor
};

class SoloBalls {
 public:
  using State = spelling::State;
  struct Outcome {
    /// False if an anchored ball isn't dropped at its place, or if offsets leave no room for an
    /// active ball's start.
    bool possible = true;
    Filling alone{};    ///< by ball: the bin that it fills alone
    Filling filling{};  ///< same as `alone`, without second balls in a bin
    std::uint32_t filled = 0;
    /// The first failure among the balls simulated for this outcome. A failed ball is guessed to
    /// fill no bin.
    plan::FailurePointer failure{};
  };
  /// A failed simulation leaves a usable guess.
  static constexpr bool k_guesses_on_failure = true;

  /// A state is possible only if it drops each anchored ball at the anchored place.
  SoloBalls(const Spelling& world, Anchor anchor) : world_(&world), anchor_(std::move(anchor)) {}

  State draw_prior(random::Stream& stream) const;
  double log_prior(const State& state) const;
  Outcome simulate(const State& state) const;
  /// Simulates the balls that differ. If a partition vertex differs, simulates all balls.
  Outcome simulate_from(const State& state, const State& from, const Outcome& of_from) const;
  double log_constraint(const Outcome& outcome) const;
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  /// Returns false: only a real simulation counts overlapping starts.
  bool starts_overlap(const Outcome& /*outcome*/) const { return false; }
  double log_constraint_at_most(const State& state) const;
  bool satisfied(const Outcome& outcome) const;
  sampling::Proposal<State> propose(const State& state, const Outcome& outcome,
                                    std::span<const double> scales, random::Stream& stream) const;
  double log_q_ratio(const State& state, const Outcome& outcome,
                     const sampling::Proposal<State>& proposal,
                     const Outcome& candidate_outcome) const;
  bool has_scale(std::uint32_t kind) const;
  std::uint32_t proposal_kinds() const;

 private:
  bool leaves_anchored(const State& state) const;
  /// Computes which bins are filled: first the anchored balls' bins, then bins that other balls
  /// fill. A bin counts only for the first ball that fills it.
  void settle(Outcome& outcome) const;

  const Spelling* world_;
  Anchor anchor_;
};

static_assert(sampling::BoundsConstraint<SoloBalls>);
static_assert(sampling::ProposesByOutcome<SoloBalls>);
static_assert(sampling::SimulatesChanges<SoloBalls>);
static_assert(sampling::MayFail<SoloBalls>);

}  // namespace sleight::worlds::spelling
