// Tests that islands' estimates are unbiased, and that particle steps leave the target invariant.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/statistical/support/staged_toy.h"
#include "tests/support/property.h"
#include "worker/sampling/particle_steps.h"

namespace sleight::statistical::islands_test {

using Toy = StagedToy;
using Guide = StagedToy::Guide;
using ToyParticle = sampling::ParticleSample<Toy>;

constexpr std::uint64_t k_seed = 141421;
constexpr double k_never = 0;   ///< A resample_below that never resamples.
constexpr double k_always = 2;  ///< A resample_below that always resamples.

sampling::ChainStreams streams_of(std::uint32_t chain) {
  return {.seed = k_seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}};
}

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Returns the distance between the mean of independent draws and the expected value, in standard
/// errors.
double errors_off(const std::vector<double>& draws, double expected) {
  const MeanWithError mean = mean_of_independent(draws);
  return (mean.mean - expected) / mean.standard_error;
}

struct Setting {
  Guide guide{};
  sampling::IslandOptions options{};
};

std::vector<Setting> settings() {
  return {{.guide = {}, .options = {.particles = 8}},
          {.guide = {}, .options = {.particles = 8, .resample_below = k_never}},
          {.guide = {}, .options = {.particles = 8, .resample_below = k_always}},
          {.guide = {.flatness = 0}, .options = {.particles = 3, .resample_below = k_always}},
          {.guide = {.log_fallen = 0}, .options = {.particles = 1}},
          {.guide = {}, .options = {.particles = 40, .inverse_temperature = 0.4}},
          {.guide = {}, .options = {.particles = 5, .inverse_temperature = 0}}};
}

template <class Make>
void expect_unbiased(const Make& make, std::uint32_t chain) {
  // In the fast tier, 4,000 islands suffice. With this number, mutants/islands rejects every
  // mutant.
  const std::uint64_t islands = property::of_tier(4'000, 10'000);
  const Toy toy;
  for (const Setting& setting : settings()) {
    const std::vector<double> masses = toy.masses(setting.options.inverse_temperature);
    const std::vector<double> prior = toy.masses(0);
    double satisfied = 0;
    double rescued = 0;
    for (Toy::State state = 0; state < Toy::k_states; ++state) {
      if (toy.satisfied(toy.simulate(state))) satisfied += prior[state];
      if (Toy::has_fallen(state)) rescued += masses[state];
    }
    std::vector<double> z;
    std::vector<double> satisfied_z;
    std::vector<double> rescued_z;
    for (std::uint64_t island = 0; island < islands; ++island) {
      const auto made =
          make(sampling::Islands(toy, setting.guide, setting.options, streams_of(chain++)));
      ASSERT_EQ(made.drawn.has_value(), made.log_z > sampling::k_log_zero);
      z.push_back(std::exp(made.log_z));
      satisfied_z.push_back(std::exp(made.log_satisfied));
      rescued_z.push_back(made.drawn && Toy::has_fallen(made.drawn->state) ? z.back() : 0);
    }
    fmt::print("{} particles, beta {}: Z {:.4f}, off by {:.2f}, {:.2f} and {:.2f} errors\n",
               setting.options.particles, setting.options.inverse_temperature, sum(masses),
               errors_off(z, sum(masses)), errors_off(satisfied_z, satisfied),
               errors_off(rescued_z, rescued));
    EXPECT_LT(std::abs(errors_off(z, sum(masses))), 4);
    EXPECT_LT(std::abs(errors_off(satisfied_z, satisfied)), 4);
    EXPECT_LT(std::abs(errors_off(rescued_z, rescued)), 4);
  }
}

TEST(Islands, EstimatesAreUnbiased) {
  // Goal: free islands estimate Z and P(satisfied) without bias, whatever the number of particles,
  // the guide and the resampling are. The product of Z and an indicator of the drawn state is
  // unbiased too. Method: make many islands in each of 7 settings. Compare the means of the three
  // estimates with enumeration. The means must agree within 4 standard errors. Correct code fails
  // once in 750 runs with new seeds.
  expect_unbiased([](const auto& islands) { return islands.free(0); }, 0);
}

TEST(Islands, EstimatesOfParticlesThatChooseTogetherAreUnbiased) {
  // Goal: joint islands estimate Z and P(satisfied) without bias.
  expect_unbiased([](const auto& islands) { return islands.joint(0); }, 20'000'000);
}

TEST(Islands, AFifthOfTheToyIsRescued) {
  // Goal: let psi be 0 for a fallen walker. Then states that islands never reach have about a fifth
  // of the toy's mass.
  const Toy toy;
  const std::vector<double> masses = toy.masses(1);
  double rescued = 0;
  for (Toy::State state = 0; state < Toy::k_states; ++state)
    rescued += Toy::has_fallen(state) ? masses[state] : 0;
  EXPECT_GT(rescued / sum(masses), 0.15);
  EXPECT_LT(rescued / sum(masses), 0.3);
}

TEST(Islands, AHardPotentialLeavesOutWhatIsRescued) {
  // Goal: if psi is 0 for a fallen walker, islands estimate the mass of the states that they reach,
  // and draw no other state. Method: enumerate the mass of all states in which the walker never
  // falls. Compare this mass with the mean Z of 10,000 islands.
  const Toy toy;
  const Guide guide{.log_fallen = sampling::k_log_zero};
  const std::vector<double> masses = toy.masses(1);
  double reachable = 0;
  for (Toy::State state = 0; state < Toy::k_states; ++state)
    reachable += Toy::has_fallen(state) ? 0 : masses[state];
  std::vector<double> z;
  for (std::uint32_t island = 0; island < 10'000; ++island) {
    const auto made =
        sampling::Islands(toy, guide, {.particles = 4}, streams_of(1'000'000 + island)).free(0);
    z.push_back(std::exp(made.log_z));
    ASSERT_FALSE(made.drawn && Toy::has_fallen(made.drawn->state));
  }
  EXPECT_LT(std::abs(errors_off(z, reachable)), 4);
  EXPECT_GT(std::abs(errors_off(z, sum(masses))), 10) << "the test can't tell the two";
}

using Step = std::function<void(const Toy&, const sampling::ChainStreams&, std::uint64_t number,
                                ToyParticle&)>;

struct Kept {
  double after_one = 0;
  double after_ten = 0;
  double moved = 0;  ///< Share of first steps that changed the state.
};

Kept kept_by(const Step& step, double beta, std::uint32_t first_chain, std::uint32_t draws) {
  const Toy toy;
  std::vector<double> masses = toy.masses(beta);
  const double total = sum(masses);
  for (double& mass : masses)
    mass /= total;
  std::vector<double> after_one(Toy::k_states, 0.0);
  std::vector<double> after_ten(Toy::k_states, 0.0);
  int moved = 0;
  for (std::uint32_t i = 0; i < draws; ++i) {
    const sampling::ChainStreams streams = streams_of(first_chain + i);
    random::Stream start = streams.at(random::Purpose::start, 0);
    const auto state = static_cast<Toy::State>(random::draw_by_share(masses, start));
    ToyParticle current{.sample = sampling::evaluate(toy, state)};
    for (std::uint64_t number = 0; number < 10; ++number) {
      step(toy, streams, number, current);
      if (number > 0) continue;
      ++after_one[current.sample.state];
      moved += current.sample.state != state ? 1 : 0;
    }
    ++after_ten[current.sample.state];
  }
  return {.after_one = chi_square_p(after_one, masses),
          .after_ten = chi_square_p(after_ten, masses),
          .moved = moved / static_cast<double>(draws)};
}

/// Number of chains per setting. With as few chains, mutants/islands rejects every mutant. The long
/// run (SLEIGHT_SOAK=1) uses many more chains.
std::uint32_t draws() {
  return property::long_run() ? 200'000
                              : static_cast<std::uint32_t>(property::of_tier(1'500, 4'000));
}

/// Expects that steps in each setting move exact draws but keep their distribution.
void expect_kept(std::uint32_t first_chain,
                 const std::function<void(const sampling::Islands<Toy>&, std::uint64_t number,
                                          ToyParticle&)>& step) {
  for (const Setting& setting : settings()) {
    if (setting.options.particles < 2) continue;
    const Step of_setting = [&](const Toy& toy, const sampling::ChainStreams& streams,
                                std::uint64_t number, ToyParticle& current) {
      step(sampling::Islands(toy, setting.guide, setting.options, streams), number, current);
    };
    const Kept kept =
        kept_by(of_setting, setting.options.inverse_temperature, first_chain, draws());
    first_chain += draws();
    fmt::print("{} particles: p {:.3g} and {:.3g}, {:.2f} moved\n", setting.options.particles,
               kept.after_one, kept.after_ten, kept.moved);
    EXPECT_GT(kept.after_one, 1e-5);
    EXPECT_GT(kept.after_ten, 1e-5);
    EXPECT_GT(kept.moved, 0.1);
  }
}

TEST(ParticleSteps, ConditionalStepsKeepTheTarget) {
  // Goal: conditional steps (particle Gibbs) of two or more particles leave the target invariant at
  // any temperature and resampling threshold. Method: move exact draws by one step and by ten
  // steps. Compare the states with enumeration after both.
  expect_kept(20'000'000, [](const auto& islands, std::uint64_t number, ToyParticle& current) {
    const std::uint32_t ground = Toy::ground_of(current.sample.state);
    sampling::conditional_step(islands, number, current);
    ASSERT_EQ(Toy::ground_of(current.sample.state), ground);
  });
}

TEST(ParticleSteps, IndependenceStepsKeepTheTarget) {
  // Goal: independence steps leave the target invariant. Method: move exact draws by one step and
  // by ten steps. Compare the states with enumeration after both. Each chain's first step draws an
  // island given the exact draw.
  expect_kept(60'000'000, [](const auto& islands, std::uint64_t number, ToyParticle& current) {
    sampling::independence_step(islands, 2 * number, current);
  });
}

/// What a chain does with its island after an accepted local move.
enum class AfterLocalMove { forgets_z, keeps_z, takes_the_draw };

/// Makes an independence step, then three local moves.
Step mixed(const Setting& setting, AfterLocalMove after) {
  return [setting, after](const Toy& toy, const sampling::ChainStreams& streams,
                          std::uint64_t number, ToyParticle& current) {
    const sampling::Islands islands(toy, setting.guide, setting.options, streams);
    // Make the mistake: if the island is stale, replace the state by the new island's draw.
    if (!current.log_z && after == AfterLocalMove::takes_the_draw)
      sampling::conditional_step(islands, 1000 + number, current);
    sampling::independence_step(islands, 2 * number, current);
    for (std::uint64_t local = 0; local < 3; ++local) {
      const auto report =
          sampling::metropolis_hastings_step(toy, setting.options.inverse_temperature, streams,
                                             1000 + 3 * number + local, current.sample);
      if (report.accepted && after != AfterLocalMove::keeps_z) current.log_z.reset();
    }
  };
}

TEST(ParticleSteps, MixedWithLocalMovesTheyKeepTheTarget) {
  // Goal: chains that mix independence steps with local moves leave the target invariant. The
  // target stays invariant even if a potential of 0 makes some states reachable only by local
  // moves. Method: move exact draws by one step and by ten steps. Compare the states with
  // enumeration after both.
  const std::vector<Setting> settings{
      {.guide = {}, .options = {.particles = 2}},
      {.guide = {}, .options = {.particles = 8}},
      {.guide = {.log_fallen = sampling::k_log_zero}, .options = {.particles = 3}}};
  std::uint32_t chain = 400'000'000;
  for (const Setting& setting : settings) {
    const Kept kept = kept_by(mixed(setting, AfterLocalMove::forgets_z), 1, chain, draws());
    chain += draws();
    fmt::print("{} particles: p {:.3g} and {:.3g}\n", setting.options.particles, kept.after_one,
               kept.after_ten);
    EXPECT_GT(kept.after_one, 1e-5);
    EXPECT_GT(kept.after_ten, 1e-5);
  }
}

TEST(ParticleSteps, MistakesWithStaleIslandsAreCaught) {
  // Goal: the invariance test of mixed chains rejects two mistakes with stale islands. Method: run
  // a chain that keeps Z after a local move. Run another chain: if the old island is stale, the new
  // island's draw replaces the state.
  const Setting two{.guide = {}, .options = {.particles = 2}};
  const Setting eight{.guide = {}, .options = {.particles = 8}};
  const Kept keeps_z = kept_by(mixed(two, AfterLocalMove::keeps_z), 1, 800'000'000, 60'000);
  const Kept takes_the_draw =
      kept_by(mixed(eight, AfterLocalMove::takes_the_draw), 1, 900'000'000, 60'000);
  fmt::print("p {:.3g} and {:.3g}\n", keeps_z.after_ten, takes_the_draw.after_ten);
  EXPECT_LT(keeps_z.after_ten, 1e-5);
  EXPECT_LT(takes_the_draw.after_ten, 1e-5);
}

}  // namespace sleight::statistical::islands_test
