// Tests that tempered transitions leave their target invariant and are reversible, which is
// stronger.
#include "worker/sampling/tempered_transition.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/statistical/support/toy_worlds.h"
#include "tests/support/property.h"

namespace sleight::statistical::tempered_transition_test {

constexpr std::uint64_t k_seed = 667430;
constexpr std::size_t k_places = RuggedRing::k_places;

sampling::ChainStreams streams_of(std::uint64_t chain) {
  return {.seed = k_seed,
          .chain = base::ChainId{static_cast<std::uint32_t>(chain)},
          .replica = base::ReplicaId{0}};
}

TEST(TemperedTransition, KeepsADiscreteDistribution) {
  // Goal: tempered transitions leave the target invariant, and a transition is as likely as its
  // reverse. Method: make exact draws at two inverse temperatures. Move the draws by excursions
  // that end at the prior or at an inverse temperature above 0. After one transition and after ten
  // transitions, compare the counts of places with enumeration in chi-square tests. For the first
  // transition, compare the number of moves from i to j with the number of moves from j to i. All
  // 18 p-values must be above 1e-6. Excursions to the prior must connect parts of the ring that no
  // plain step connects.
  struct Way {
    double beta;
    std::vector<double> below;
    std::uint32_t steps;
  };
  const std::vector<Way> ways{{1, {0.5}, 1}, {1, {0.6, 0.3, 0.1}, 2}, {1, {0.5, 0.2, 0}, 1},
                              {1, {0}, 1},   {0.6, {0.3, 0.05}, 3},   {0.6, {0.4, 0.2, 0.1, 0}, 2}};
  // The fast tier uses as many draws as mutants/kernel_checks.cpp, which rejects every mutant.
  const std::uint64_t draws = property::of_tier(12'000, 100'000);
  const RuggedRing ring;
  std::uint64_t chain = 0;
  for (const Way& way : ways) {
    const std::vector<double> exact = RuggedRing::exact(way.beta);
    std::vector<double> after_one(k_places, 0.0);
    std::vector<double> after_ten(k_places, 0.0);
    std::vector<double> pairs(k_places * k_places, 0.0);
    int accepted = 0;
    int crossed = 0;
    const auto part = [](std::uint32_t place) { return place < 3 || place > 12 ? 0 : place / 4; };
    for (std::uint64_t i = 0; i < draws; ++i) {
      const sampling::ChainStreams streams = streams_of(chain++);
      random::Stream start = streams.at(random::Purpose::start, 0);
      sampling::Sample<RuggedRing> sample =
          sampling::evaluate(ring, ring.draw_exact(way.beta, start));
      const sampling::Excursion excursion{.inverse_temperature = way.beta,
                                          .below = way.below,
                                          .steps = way.steps,
                                          .proposal_scales = {}};
      for (std::uint64_t scan = 1; scan <= 10; ++scan) {
        const std::uint32_t before = sample.state;
        const sampling::ExcursionReport report =
            sampling::tempered_transition(ring, excursion, streams, scan, sample);
        ASSERT_TRUE(report.accepted || sample.state == before);
        ASSERT_EQ(report.from_prior, report.accepted && way.below.back() == 0);
        ASSERT_EQ(sample.log_constraint, RuggedRing::k_log_constraint[sample.state]);
        if (scan > 1) continue;
        ++after_one[sample.state];
        ++pairs[before * k_places + sample.state];
        accepted += report.accepted ? 1 : 0;
        crossed += part(before) != part(sample.state) ? 1 : 0;
      }
      ++after_ten[sample.state];
    }
    // If n transitions connect two places, the number of forward transitions is binomial with
    // probability 1/2.
    double statistic = 0;
    int freedom = 0;
    for (std::size_t i = 0; i < k_places; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double there = pairs[i * k_places + j];
        const double back = pairs[j * k_places + i];
        if (there + back < 20) continue;
        statistic += (there - back) * (there - back) / (there + back);
        ++freedom;
      }
    }
    const double p_one = chi_square_p(after_one, exact);
    const double p_ten = chi_square_p(after_ten, exact);
    const double p_reverse = boost::math::gamma_q(0.5 * freedom, 0.5 * statistic);
    fmt::print(
        "beta {}, {} below: p {:.3g}, {:.3g}, reversible {:.3g} ({} pairs); accepted {:.3f}, "
        "crossed {}\n",
        way.beta, way.below.size(), p_one, p_ten, p_reverse, freedom,
        accepted / static_cast<double>(draws), crossed);
    EXPECT_GT(p_one, 1e-6) << "seed " << k_seed;
    EXPECT_GT(p_ten, 1e-6) << "seed " << k_seed;
    EXPECT_GT(p_reverse, 1e-6) << "seed " << k_seed;
    EXPECT_EQ(crossed > 0, way.below.back() == 0);
  }
}

TEST(TemperedTransition, CrossesBetweenModes) {
  // Goal: if proposal scales differ, tempered transitions leave a target of two modes invariant,
  // and cross between the modes. Method: move 10,000 exact draws by one transition and by ten
  // transitions. After both, compare the draws with fresh exact draws in a Kolmogorov-Smirnov test.
  // Both p-values must be above 1e-6.
  TwoModes world;
  world.prior_sd = 4;
  world.step_sd = 2;
  std::vector<double> below;
  for (double beta = 0.5; beta > 1e-3; beta *= 0.5)
    below.push_back(beta);
  below.push_back(0);
  const std::vector<double> scales{0.5};
  std::vector<double> once;
  std::vector<double> ten_times;
  std::vector<double> fresh;
  int crossed = 0;
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    const sampling::ChainStreams streams = streams_of(2'000'000'000 + 2 * i);
    random::Stream start = streams.at(random::Purpose::start, 0);
    sampling::Sample<TwoModes> sample = sampling::evaluate(world, world.draw_exact(start));
    for (std::uint64_t scan = 1; scan <= 10; ++scan) {
      const bool left = sample.state < 0;
      sampling::tempered_transition(
          world, {.inverse_temperature = 1, .below = below, .steps = 2, .proposal_scales = scales},
          streams, scan, sample);
      crossed += left != (sample.state < 0) ? 1 : 0;
      if (scan == 1) once.push_back(sample.state);
    }
    ten_times.push_back(sample.state);
    random::Stream other = streams_of(2'000'000'001 + 2 * i).at(random::Purpose::start, 0);
    fresh.push_back(world.draw_exact(other));
  }
  const double p_one = kolmogorov_smirnov_p(once, fresh);
  const double p_ten = kolmogorov_smirnov_p(ten_times, fresh);
  fmt::print("p {:.3g}, {:.3g}; crossed {} of 100000\n", p_one, p_ten, crossed);
  EXPECT_GT(p_one, 1e-6) << "seed " << k_seed;
  EXPECT_GT(p_ten, 1e-6) << "seed " << k_seed;
  EXPECT_GT(crossed, 500);
}

}  // namespace sleight::statistical::tempered_transition_test
