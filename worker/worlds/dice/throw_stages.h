// Dice as a world that acts in stages (worker/sampling/stages.h): stage i adds die i to the throw,
// looked at alone first, then with the dice before it.
//
// Ground: the table, and for each die a pool of n throws that an island's particles share. They are
// drawn from the die's q (throw_map.h), and each is simulated once with no other die, so that a
// particle may look at all of them before it chooses.
//
// Choice. Throw j of the die's pool with probability v_j g_j / S, S the sum over the pool;
// v = p / q, and g guesses how promising the throw is: p_c of the die's goals by the lone throw,
// but e^log_floor at least, since the other dice may turn any throw into one that ends as is
// wanted. The weight is
//
//   S / (n g_j).
//
// Why that is right on average over pools: the probability of throw j times its weight is v_j / n;
// summed over a pool that is drawn from q, its mean is p, whatever g is. A die has a pool of its
// own, so no throw is used twice.
//
// Given a state (ground_given), its table is the ground and its throws stand first in their pools;
// the rest is drawn as always. Places say nothing, since a pool's throws are drawn alike. So
// conditional islands keep the table, which local moves change.
//
// Potential: p_c of the goals of the dice so far, e^log_floor at least: above 0, so that every
// state is reached, also one whose last die pushes another one to its place.
//
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/plan/failure.h"
#include "common/random/stream.h"
#include "worker/sampling/burn_in_judge.h"
#include "worker/sampling/stage_search.h"
#include "worker/sampling/stages.h"
#include "worker/worlds/dice/dice.h"
#include "worker/worlds/dice/throw_map.h"

namespace sleight::worlds::dice {

/// Throws of each die alone that its map is learnt from; each on a table of its own.
inline constexpr std::uint32_t k_throws_of_map = 100;

/// Frozen before anything counts.
struct ThrowGuide {
  std::vector<ThrowMap> maps;                    ///< by die
  std::vector<plan::FailurePointer> failures{};  ///< of the throws that the maps are made of
  std::uint32_t throws_of_pool = 64;             ///< of each die
  /// Of guesses and potentials. Lower, a die that another one pushes to its place weighs so much
  /// that few islands have most of Z: at -8 the largest of 300 had 18% of it, at -3 3% (two dice).
  double log_floor = -3;
};

/// A throw of a die's pool.
struct PoolThrow {
  DieThrow thrown;
  double v = 1;
  double log_guess = 0;
};

struct ThrowPool {
  std::vector<PoolThrow> throws;
  std::vector<double> shares;  ///< v g
  double log_sum = 0;          ///< log S
};

struct ThrowGround {
  std::uint64_t table_key = 0;
  Overrides overrides;
  std::vector<ThrowPool> pools;            ///< by die
  std::vector<Outcome> first_die_alone{};  ///< by throw of the first pool: of the first stage too
  std::vector<sampling::SimulationReport> simulations{};
};

struct ThrowPrefix {
  State state;
  Outcome outcome;
};

class ThrowBuilder;

class StagedDice : public Dice {
 public:
  using Guide = ThrowGuide;
  using Ground = ThrowGround;
  using Prefix = ThrowPrefix;

  explicit StagedDice(const Parameters& parameters, Replays replays = Replays::yes);

  /// The guide of all runs with this seed.
  Guide learn(std::uint64_t seed) const;
  std::span<const plan::FailurePointer> failures_of(const Guide& guide) const {
    return guide.failures;
  }
  ThrowBuilder builder(const Guide& guide) const;
  /// Nothing of dice has a side that all searches start on: tables and throws come from all over.
  std::vector<sampling::BurnInValue> burn_in_values() const;
  std::vector<double> burn_in_values_of(const State& state, const Outcome& outcome) const;
  /// Simulations are whole ones.
  Outcome simulate_to_rest(const State& state) const { return simulate(state); }

  std::uint32_t stages() const { return static_cast<std::uint32_t>(dice()); }
  /// "die 2 of 6".
  std::string stage_name(std::uint32_t stage) const;
  Ground draw_ground(const Guide& guide, random::Stream& stream) const;
  Ground ground_given(const Guide& guide, const State& state, random::Stream& stream) const;
  Prefix no_stages(const Guide& guide, const Ground& ground) const;
  sampling::Extension extend(const Guide& guide, const Ground& ground, std::uint32_t stage,
                             Prefix& prefix, random::Stream& stream) const;
  sampling::Extension extend_as(const Guide& guide, const Ground& ground, const State& state,
                                std::uint32_t stage, Prefix& prefix) const;
  double log_potential(const Guide& guide, const Ground& ground, const Prefix& prefix) const;
  State state_of(const Ground& /*ground*/, const Prefix& prefix) const { return prefix.state; }
  Outcome outcome_of(const Prefix& prefix) const { return prefix.outcome; }
  std::span<const sampling::SimulationReport> simulations_of(const Ground& ground) const {
    return ground.simulations;
  }

  /// The world of a die alone, and that of the first dice up to and with one: with their goals.
  const Dice& alone(std::size_t die) const { return die == 0 ? first_[0] : alone_[die - 1]; }
  const Dice& first(std::size_t dice) const { return first_[dice - 1]; }

 private:
  /// Draws the pools; a given state's throws stand first.
  Ground ground_of(const Guide& guide, State table, const State* given,
                   random::Stream& stream) const;
  /// Adds the throw at this place of the stage's pool.
  sampling::Extension add(const Ground& ground, std::uint32_t stage, std::size_t place,
                          Prefix& prefix) const;

  bool thrown_at_once_ = true;
  std::vector<Dice> first_;  ///< by number of dice, from 1
  std::vector<Dice> alone_;  ///< by die, from the second on: the first one alone is first_[0]
};

static_assert(sampling::ActsInStages<StagedDice>);

/// Throws built die by die, for search: each is thrown alone until it ends as is wanted, by draws
/// from its map and a walk from the best of them; then with the dice before it.
class ThrowBuilder {
 public:
  using Prefix = ThrowPrefix;

  /// REQUIRES: world and guide outlive it.
  ThrowBuilder(const StagedDice& world, const ThrowGuide& guide);

  std::uint32_t stages() const { return world_->stages(); }
  /// A try is a walk of many simulations.
  sampling::SearchLimits limits() const { return {.tries_of_stage = 10, .turns_per_stage = 10}; }
  /// A table of the prior without dice.
  Prefix start(random::Stream& stream) const;
  std::optional<Prefix> attempt(const Prefix& prefix, std::uint32_t stage,
                                sampling::SearchEffort& effort, random::Stream& stream) const;
  bool is_solution(const Prefix& prefix) const { return world_->satisfied(prefix.outcome); }
  const State& state_of(const Prefix& prefix) const { return prefix.state; }
  const Outcome& outcome_of(const Prefix& prefix) const { return prefix.outcome; }

 private:
  /// A die alone on the prefix's table, and what came of it.
  struct Lone {
    State state;
    Outcome outcome;
    double log_target = 0;  ///< log p_w p_c, up to a constant
  };

  Lone looked_at(std::size_t die, State state, sampling::SearchEffort& effort) const;
  /// A throw of the die alone that ends as is wanted; nothing after so many tries.
  std::optional<Lone> promising_throw(const Prefix& prefix, std::size_t die,
                                      sampling::SearchEffort& effort, random::Stream& stream) const;

  const StagedDice* world_;
  const ThrowGuide* guide_;
  ProposalParameters walk_;  ///< proposals of one component alone
};

static_assert(sampling::StageBuilder<ThrowBuilder>);

}  // namespace sleight::worlds::dice
