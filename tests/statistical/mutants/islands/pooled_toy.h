// A world that acts in stages. Like balls that spell, it chooses drops from a pool
// (worker/worlds/spelling/pouring_stages.h explains the weights). The world is small enough to
// enumerate, and can make one mistake.
//
// There are three balls and two bins. A ball drops from one of five spots, and falls into a bin or
// elsewhere. A ball takes part with probability 1/2. A state stores each ball's spot, or that the
// ball takes no part. If a ball drops above a full bin, it falls elsewhere. So states whose balls
// drop from different spots are worth more.
//
// A pool has two strata of three drops, the minimum for three balls. Stratum b is drawn from q_b =
// 0.05 p + 0.95 d_b, where d_b is aimed at bin b.
//
// Dice have a simpler pool: one stratum and one choice (worker/worlds/dice/throw_stages.h). The
// weight of dice is S / (K g) without the terms for used drops. Thread safety: const functions may
// be called from several threads at once.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/sampling/stages.h"

namespace sleight::statistical {

/// A mistake of the world. island_mistakes.cpp explains why a check detects it.
enum class PoolMistake {
  none,
  pool_weight_left_out,
  unused_drops_counted,
  guess_left_in,
  part_left_out,
  prior_weight_left_out,
  drop_used_twice,
  walk_count_left_out,
  used_drops_in_the_sum,
  stratum_used_up,
  retained_stands_first,
  retained_not_in_the_pool,
  retained_drops_share_a_place,
};

class PooledToy {
 public:
  static constexpr std::uint32_t k_balls = 3;
  static constexpr std::uint32_t k_spots = 5;
  static constexpr std::uint32_t k_bins = 2;
  static constexpr std::uint32_t k_choices = 1 + k_spots;
  static constexpr std::uint32_t k_states = k_choices * k_choices * k_choices;

  /// The balls' choices as digits. The first digit is the first ball's. A digit is 0 if the ball
  /// takes no part, otherwise 1 + spot.
  using State = std::uint32_t;
  struct Outcome {
    std::array<bool, k_bins> is_full{};
    std::uint32_t elsewhere = 0;
    bool operator==(const Outcome&) const = default;
  };
  struct Guide {
    double takes_part = 0.8;
    double log_elsewhere = -0.5;
  };
  struct Ground {
    std::vector<std::uint32_t> spots{};  ///< Spots of the pool's drops, stratum by stratum.
    /// Each ball's place in the pool. Used only if a state is given.
    std::array<std::uint32_t, k_balls> retained{};
  };
  struct Prefix {
    State digits = 0;
    Outcome outcome{};
    std::vector<bool> is_used{};  ///< By drop of the pool.
  };

  explicit PooledToy(PoolMistake mistake = PoolMistake::none) : mistake_(mistake) {}

  static std::uint32_t choice_of(State state, std::uint32_t ball);

  State draw_prior(random::Stream& stream) const;
  double log_prior(const State& state) const;
  Outcome simulate(const State& state) const;
  double log_constraint(const Outcome& outcome) const;
  bool satisfied(const Outcome& outcome) const { return outcome.is_full[0] && outcome.is_full[1]; }
  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const;
  std::uint32_t proposal_kinds() const { return 1; }

  std::uint32_t stages() const { return k_balls; }
  Ground draw_ground(const Guide& guide, random::Stream& stream) const;
  Ground ground_given(const Guide& guide, const State& state, random::Stream& stream) const;
  std::span<const sampling::SimulationReport> simulations_of(const Ground&) const { return {}; }
  Prefix no_stages(const Guide& guide, const Ground& ground) const;
  sampling::Extension extend(const Guide& guide, const Ground& ground, std::uint32_t stage,
                             Prefix& prefix, random::Stream& stream) const;
  sampling::Extension extend_as(const Guide& guide, const Ground& ground, const State& state,
                                std::uint32_t stage, Prefix& prefix) const;
  double log_potential(const Guide& guide, const Ground& ground, const Prefix& prefix) const;
  State state_of(const Ground&, const Prefix& prefix) const { return prefix.digits; }
  Outcome outcome_of(const Prefix& prefix) const { return prefix.outcome; }

  /// p_w p_c^beta of each state.
  std::vector<double> masses(double beta) const;

 private:
  /// Distribution of the drops that are chosen after a prefix.
  struct Choices {
    std::vector<double> shares{};  ///< v s g of unused drops, 0 of others.
    double sum = 0;                ///< The sum S.
  };

  bool makes(PoolMistake mistake) const { return mistake_ == mistake; }
  std::uint32_t drops_of_stratum() const;
  std::uint32_t unused_of_stratum(const Prefix& prefix, std::uint32_t bin) const;
  Choices choices(const Ground& ground, const Prefix& prefix) const;
  sampling::Extension leave_out(const Guide& guide, Prefix& prefix) const;
  sampling::Extension drop(const Guide& guide, const Ground& ground, std::uint32_t place,
                           Prefix& prefix) const;

  PoolMistake mistake_;
};
static_assert(sampling::ActsInStages<PooledToy>);

}  // namespace sleight::statistical
