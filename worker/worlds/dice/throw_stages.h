// Dice as a world that acts in stages (worker/sampling/stages.h). Stage i adds die i to the throw.
// The die is simulated first alone, then with the dice before it.
//
// The ground has the table, and a pool of n throws for each die. An island's particles share the
// pools. The throws are drawn from the die's q (throw_map.h). Each throw is simulated once without
// other dice, so a particle can compare all throws before it chooses.
//
// Choice. A particle chooses throw j of the die's pool with probability v_j g_j / S. Here v = p /
// q, and S is the sum of v_j g_j over the pool. The guess g is p_c of the die's goals for the lone
// throw. The guess is at least e^log_floor, because the other dice may make any throw meet the
// goals. The weight is
//
//   S / (n g_j).
//
// The estimate is unbiased over pools: the probability of throw j times the throw's weight is v_j /
// n. For any g, the sum over a pool drawn from q has mean p. Each die has its own pool, so no throw
// is used twice.
//
// If a state is given (ground_given), the ground has the state's table, and the state's throws come
// first in their pools. The other throws of the pools are drawn as usual. A throw's place in its
// pool doesn't matter, since all throws of a pool are drawn alike. So conditional islands keep the
// table; local moves change it.
//
// The potential is p_c of the added dice's goals, but at least e^log_floor. So the potential is
// above 0, and every state can be reached, even a state whose last die pushes another die to its
// goal. Thread safety: const functions may be called from several threads at once.
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

/// Number of lone throws from which a die's map is learnt. Each throw has a different table.
inline constexpr std::uint32_t k_throws_of_map = 100;

/// Fixed before sampling starts.
struct ThrowGuide {
  std::vector<ThrowMap> maps;                    ///< by die
  std::vector<plan::FailurePointer> failures{};  ///< of the throws for the maps
  std::uint32_t throws_of_pool = 64;             ///< per die
  /// Minimum log guess and log potential. If the minimum is lower, a die that another die pushes to
  /// its goal weighs so much that few islands hold most of Z. Measured with two dice: among 300
  /// islands, the largest held 18% of Z if the minimum was -8, and 3% if it was -3.
  double log_floor = -3;
};

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
  std::vector<Outcome> first_die_alone{};  ///< by throw; outcomes of the first stage
  std::vector<sampling::SimulationReport> simulations{};
};

struct ThrowPrefix {
  State state;
  Outcome outcome{};
};

class ThrowBuilder;

class StagedDice : public Dice {
 public:
  using Guide = ThrowGuide;
  using Ground = ThrowGround;
  using Prefix = ThrowPrefix;

  explicit StagedDice(const Parameters& parameters);

  /// Returns the guide that all runs with this seed share.
  Guide learn(std::uint64_t seed) const;
  std::span<const plan::FailurePointer> failures_of(const Guide& guide) const {
    return guide.failures;
  }
  ThrowBuilder builder(const Guide& guide) const;
  /// No value starts at one end of its range, because searches find tables and throws from the
  /// whole range.
  std::vector<sampling::BurnInValue> burn_in_values() const;
  std::vector<double> burn_in_values_of(const State& state, const Outcome& outcome) const;
  /// Calls `simulate`, which always runs to the end.
  Outcome simulate_to_rest(const State& state) const { return simulate(state); }

  std::uint32_t stages() const { return static_cast<std::uint32_t>(dice()); }
  /// Returns a name such as "die 2 of 6".
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

  /// Worlds that contain only one die or only the first dice, and only their goals.
  const Dice& alone(std::size_t die) const { return die == 0 ? first_[0] : alone_[die - 1]; }
  const Dice& first(std::size_t dice) const { return first_[dice - 1]; }

 private:
  Ground ground_of(const Guide& guide, State table, const State* given,
                   random::Stream& stream) const;
  sampling::Extension add(const Ground& ground, std::uint32_t stage, std::size_t place,
                          Prefix& prefix) const;

  bool thrown_at_once_ = true;
  std::vector<Dice> first_;  ///< by number of dice minus 1
  std::vector<Dice> alone_;  ///< by die minus 1; the first die alone is first_[0]
};

static_assert(sampling::ActsInStages<StagedDice>);

/// Builds throws die by die for search. Each die is first thrown alone until it meets its goals:
/// draws from its map come first, then a walk from the best draw. Then the die is thrown with the
/// dice before it.
class ThrowBuilder {
 public:
  using Prefix = ThrowPrefix;

  /// REQUIRES: world and guide outlive the builder.
  ThrowBuilder(const StagedDice& world, const ThrowGuide& guide);

  std::uint32_t stages() const { return world_->stages(); }
  /// Low limits, because each try is a walk of many simulations.
  sampling::SearchLimits limits() const { return {.tries_of_stage = 10, .turns_per_stage = 10}; }
  /// Draws a table from the prior, and returns it without dice.
  Prefix start(random::Stream& stream) const;
  std::optional<Prefix> attempt(const Prefix& prefix, std::uint32_t stage,
                                sampling::SearchEffort& effort, random::Stream& stream) const;
  bool is_solution(const Prefix& prefix) const { return world_->satisfied(prefix.outcome); }
  const State& state_of(const Prefix& prefix) const { return prefix.state; }
  const Outcome& outcome_of(const Prefix& prefix) const { return prefix.outcome; }

 private:
  /// A die alone on the prefix's table, with its outcome.
  struct Lone {
    State state{};
    Outcome outcome{};
    double log_target = 0;  ///< log p_w p_c, up to a constant
  };

  Lone looked_at(std::size_t die, State state, sampling::SearchEffort& effort) const;
  /// Returns a lone throw that meets the die's goals. After too many tries, returns nothing.
  std::optional<Lone> promising_throw(const Prefix& prefix, std::size_t die,
                                      sampling::SearchEffort& effort, random::Stream& stream) const;

  const StagedDice* world_;
  const ThrowGuide* guide_;
  ProposalParameters walk_;  ///< proposals that change one component
};

static_assert(sampling::StageBuilder<ThrowBuilder>);

}  // namespace sleight::worlds::dice
