#include "worker/sampling/splitting.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "common/random/linear_distributions.h"

namespace sleight::sampling::splitting_test {

/// Two standard normals. Stage i is passed if normal i is above 2. p_c is exp(-x) for the first
/// normal, x. A state whose second normal is below -2 fails in the second stage.
struct Corner {
  using State = std::array<double, 2>;
  struct Outcome {
    State seen{};
    std::uint32_t judged = 0;
    plan::FailurePointer failure{};
  };
  static constexpr double k_least = 2;
  bool is_reachable = true;
  /// Mutant: claims that steps keep the prior, but shifts each step.
  double shift = 0;

  State draw_prior(random::Stream& stream) const {
    const double x = random::standard_normal(stream);
    return {x, random::standard_normal(stream)};
  }
  double log_prior(const State& state) const {
    return -(state[0] * state[0] + state[1] * state[1]) / 2;
  }
  Outcome simulate(const State& state) const { return simulate_stages(state, 2, {}); }
  Outcome simulate_stages(const State& state, std::uint32_t stages, const Outcome&) const {
    Outcome outcome{state, stages, nullptr};
    if (stages == 2 && state[1] < -k_least)
      outcome.failure = std::make_shared<const plan::SimulationFailure>();
    return outcome;
  }
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome) const {
    return simulate_from(candidate, state, outcome, 2);
  }
  Outcome simulate_from(const State& candidate, const State&, const Outcome& outcome,
                        std::uint32_t stages) const {
    EXPECT_EQ(outcome.judged, stages) << "outcomes of a step end alike";
    return simulate_stages(candidate, stages, {});
  }
  double log_constraint(const Outcome& outcome) const { return -outcome.seen[0]; }
  bool satisfied(const Outcome& outcome) const { return progress(outcome).passed == 2; }
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  bool starts_overlap(const Outcome&) const { return false; }
  std::uint32_t stages() const { return 2; }
  Progress progress(const Outcome& outcome) const {
    if (outcome.failure) return {};
    for (std::uint32_t stage = 0; stage < outcome.judged; ++stage) {
      const double missing = k_least - outcome.seen[stage];
      if (missing > 0 || (stage == 1 && !is_reachable))
        return {.passed = stage, .score = -std::fabs(missing)};
    }
    return {.passed = outcome.judged};
  }
  Proposal<State> propose(const State& state, const Outcome&, std::span<const double>,
                          random::Stream& stream) const {
    const auto kind = static_cast<std::uint32_t>(random::UniformInteger{.count = 2}.draw(stream));
    State candidate = state;
    candidate[kind] = 0.8 * state[kind] + 0.6 * random::standard_normal(stream) + shift;
    return {.candidate = candidate,
            .log_q_ratio = log_prior(state) - log_prior(candidate),
            .kind = kind};
  }
  double log_q_ratio(const State&, const Outcome&, const Proposal<State>& proposal,
                     const Outcome&) const {
    return proposal.log_q_ratio;
  }
  bool has_scale(std::uint32_t) const { return false; }
  std::uint32_t proposal_kinds() const { return 2; }
};
static_assert(PassesStages<Corner>);

constexpr auto k_tell_nobody = [](const auto&) {};

double above(double x) {
  return std::erfc(x / std::sqrt(2.0)) / 2;
}

/// Mean of the islands' estimates over the true value, and its standard error.
struct Ratio {
  double mean = 0;
  double error = 0;
};

Ratio ratio_of(const std::vector<double>& logs, double truth) {
  double sum = 0;
  double squares = 0;
  for (const double log : logs) {
    const double ratio = std::exp(log) / truth;
    sum += ratio;
    squares += ratio * ratio;
  }
  const auto count = static_cast<double>(logs.size());
  const double mean = sum / count;
  return {mean, std::sqrt((squares / count - mean * mean) / count)};
}

struct Islands {
  std::vector<double> log_satisfied;
  std::vector<double> log_z;
  std::size_t extinct = 0;
};

std::vector<Level> levels_of(const Corner& world) {
  const ChainStreams streams{.seed = 3, .chain = {}, .replica = base::ReplicaId{1}};
  return Splitting<Corner>(world, 64, streams).find_levels(k_tell_nobody);
}

Islands islands_of(const Corner& world, std::uint32_t particles, std::uint64_t count) {
  const std::vector<Level> levels = levels_of(world);
  const Splitting<Corner> splitting(world, particles, {.seed = 3, .chain = {}, .replica = {}});
  Islands islands;
  for (std::uint64_t number = 0; number < count; ++number) {
    const SplitIsland<Corner> island = splitting.island(levels, number, k_tell_nobody);
    islands.log_satisfied.push_back(island.estimate.log_satisfied);
    islands.log_z.push_back(island.estimate.log_z);
    if (!island.drawn) {
      ++islands.extinct;
      continue;
    }
    EXPECT_TRUE(world.satisfied(island.drawn->outcome));
  }
  return islands;
}

TEST(Splitting, MeansAreTrueForAnyNumberOfParticles) {
  // Goal: the mean over islands of P and of Z is the true value, also if many islands die out.
  // Method: islands of 3 and of 40 particles on a world with known values. At 3 particles, more
  // than a third of the islands are extinct, so wrong resampling, counting or steps would show.
  const double p = above(2) * above(2);
  const double z = std::exp(0.5) * above(3) * above(2);
  for (const auto& [particles, count] :
       {std::pair{3U, std::uint64_t{60000}}, std::pair{40U, std::uint64_t{4000}}}) {
    const Islands islands = islands_of({}, particles, count);
    const Ratio satisfied = ratio_of(islands.log_satisfied, p);
    EXPECT_NEAR(satisfied.mean, 1, 4 * satisfied.error) << particles;
    EXPECT_LT(satisfied.error, 0.05) << particles;
    const Ratio of_z = ratio_of(islands.log_z, z);
    EXPECT_NEAR(of_z.mean, 1, 4 * of_z.error) << particles;
    EXPECT_TRUE(particles > 3 || islands.extinct > count / 3);
  }
}

TEST(Splitting, AMutantsMeanIsWrong) {
  // Goal: the test above can fail. Method: steps that don't keep the prior.
  const Islands islands = islands_of({.shift = 0.2}, 40, 4000);
  const Ratio satisfied = ratio_of(islands.log_satisfied, above(2) * above(2));
  EXPECT_GT(std::fabs(satisfied.mean - 1), 6 * satisfied.error);
}

TEST(Splitting, LevelsAreNestedAndEnd) {
  // Goal: levels ascend and end with all stages passed; if nothing passes, the search for levels
  // ends too, and all islands are extinct. Method: the world as it is, and with a second stage that
  // is never passed.
  for (const bool is_reachable : {true, false}) {
    const Corner world{.is_reachable = is_reachable};
    const std::vector<Level> levels = levels_of(world);
    for (std::size_t i = 1; i < levels.size(); ++i)
      EXPECT_LT(levels[i - 1].least, levels[i].least);
    EXPECT_EQ(levels.back().least, Progress{.passed = 2});
    EXPECT_GT(levels.size(), 3U);
  }
  EXPECT_EQ(islands_of({.is_reachable = false}, 8, 20).extinct, 20U);
}

}  // namespace sleight::sampling::splitting_test
