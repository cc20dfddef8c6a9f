// Contract C3 for balls that spell as a world that acts in stages: islands against rejection, and
// particle steps from exact draws.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/statistical/support/spelling_fixture.h"
#include "tests/support/property.h"
#include "worker/sampling/particle_steps.h"
#include "worker/worlds/spelling/pouring_stages.h"

namespace sleight::statistical {
namespace {

using worlds::spelling::LandingMap;
using worlds::spelling::PouringGuide;
using worlds::spelling::StagedSpelling;

constexpr std::uint64_t k_seed = 173205;

sampling::ChainStreams streams_of(std::uint32_t chain) {
  return {.seed = k_seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}};
}

PouringGuide guide_of(const StagedSpelling& world, std::uint32_t drops_per_bin) {
  return {.map = LandingMap(worlds::spelling::landings_of(world, k_seed, 10)),
          .takes_part = 0.8,
          .log_elsewhere = -1.5,
          .drops_per_bin = drops_per_bin};
}

/// Estimates of one island, or of one draw of the prior.
struct Estimates {
  std::vector<double> z;
  std::vector<double> satisfied;
};

void expect_equal(const char* name, const std::vector<double>& a, const std::vector<double>& b) {
  const MeanWithError first = mean_of_independent(a);
  const MeanWithError second = mean_of_independent(b);
  const double off =
      (first.mean - second.mean) / std::hypot(first.standard_error, second.standard_error);
  fmt::print("{}: islands {:.4g} +- {:.2g}, rejection {:.4g} +- {:.2g}: {:.2f} errors\n", name,
             first.mean, first.standard_error, second.mean, second.standard_error, off);
  EXPECT_LT(std::abs(off), 4) << name;
}

TEST(SpellingIslands, AgreeWithRejection) {
  // Goal: Z and P(satisfied) of three balls by islands are those of blind throws. Method: the means
  // of islands of two guides against draws of the prior, within 4 combined standard errors.
  worlds::spelling::Parameters parameters;
  parameters.pattern = worlds::spelling::pattern_of_rows("#.#\n.#.").value();
  parameters.constraint.log_lambda = 1.5;
  const StagedSpelling world(parameters);
  const int throws = property::long_run() ? 400'000 : 30'000;
  const std::uint32_t islands = property::long_run() ? 10'000 : 600;

  // Throws with all balls active spell an eighth as often as they would with as many by chance.
  Estimates blind;
  for (int i = 0; i < throws; ++i) {
    random::Stream stream = streams_of(0).at(random::Purpose::prior, static_cast<std::uint64_t>(i));
    auto state = world.draw_prior(stream);
    blind.z.push_back(std::exp(world.log_constraint(world.simulate(state))));
    for (std::size_t ball = 0; ball < world.balls(); ++ball) {
      if (state.active[ball] != 0) continue;
      state.active[ball] = 1;
      state.drops_m[ball] = world.prior().draw_drop(stream);
    }
    blind.satisfied.push_back(world.satisfied(world.simulate(state)) ? 0.125 : 0);
  }

  PouringGuide guide = guide_of(world, 20);
  std::uint32_t chain = 1;
  for (const double takes_part : {0.8, 0.5}) {
    guide.takes_part = takes_part;
    Estimates by_islands;
    for (std::uint32_t i = 0; i < islands; ++i) {
      const auto island =
          sampling::Islands(world, guide, {.particles = 12}, streams_of(chain++)).free(0);
      by_islands.z.push_back(std::exp(island.log_z));
      by_islands.satisfied.push_back(std::exp(island.log_satisfied));
      if (island.drawn && i < 20) {
        const auto fresh = world.simulate(island.drawn->state);
        EXPECT_EQ(fresh.filling, island.drawn->outcome.filling);
      }
    }
    expect_equal("Z", by_islands.z, blind.z);
    expect_equal("P(satisfied)", by_islands.satisfied, blind.satisfied);
  }
}

/// What the tests look at of a sample.
struct Seen {
  std::vector<double> filled = std::vector<double>(3, 0.0);  ///< counts
  std::vector<double> active = std::vector<double>(3, 0.0);
  std::array<std::vector<double>, 2> drop_x_m;  ///< of each ball, if it is active

  void add(const sampling::Sample<StagedSpelling>& sample) {
    ++filled.at(sample.outcome.filled);
    ++active.at(sample.state.active_count());
    for (std::size_t ball = 0; ball < 2; ++ball)
      if (sample.state.active[ball] != 0)
        drop_x_m.at(ball).push_back(sample.state.drops_m[ball].x());
  }
};

TEST(SpellingIslands, StepsKeepExactDrawsExact) {
  // Goal: both particle steps keep p_w p_c of two balls: how many take part and fill a bin, and
  // where they are dropped. Method: exact draws by rejection; after five steps, against as many
  // other exact draws; eight p-values above 1e-5.
  const StagedSpelling world(world_with(worlds::spelling::Kernel::correct).parameters());
  const PouringGuide guide = guide_of(world, 3);
  const sampling::IslandOptions options{.particles = 4, .resample_below = 0.9};
  const int draws = property::long_run() ? 30'000 : 1'500;
  const auto exact = [&](std::uint64_t number) {
    random::Stream stream = streams_of(2'000'000).at(random::Purpose::prior, number);
    SpellingSample drawn = exact_draw(world, 1, stream);
    return sampling::Sample<StagedSpelling>{std::move(drawn.state), std::move(drawn.outcome),
                                            drawn.log_prior, drawn.log_constraint};
  };
  for (const bool conditional : {true, false}) {
    Seen after;
    Seen fresh;
    int moved = 0;
    for (int i = 0; i < draws; ++i) {
      const auto number = static_cast<std::uint64_t>(2 * i);
      sampling::ParticleSample<StagedSpelling> current{.sample = exact(number)};
      fresh.add(exact(number + 1));
      const auto before = current.sample.state;
      const sampling::ChainStreams streams =
          streams_of(3'000'000 + static_cast<std::uint32_t>(2 * i + (conditional ? 1 : 0)));
      const sampling::Islands islands(world, guide, options, streams);
      for (std::uint64_t step = 0; step < 5; ++step) {
        if (conditional) {
          sampling::conditional_step(islands, step, current);
          ASSERT_EQ(current.sample.state.offsets_m, before.offsets_m);
        } else {
          sampling::independence_step(islands, 2 * step, current);
        }
      }
      after.add(current.sample);
      moved += current.sample.state == before ? 0 : 1;
    }
    const std::vector<double> p{two_sample_p(after.filled, fresh.filled),
                                two_sample_p(after.active, fresh.active),
                                kolmogorov_smirnov_p(after.drop_x_m[0], fresh.drop_x_m[0]),
                                kolmogorov_smirnov_p(after.drop_x_m[1], fresh.drop_x_m[1])};
    fmt::print("{} steps: p {:.3g} {:.3g} {:.3g} {:.3g}, {:.2f} moved\n",
               conditional ? "conditional" : "independence", p[0], p[1], p[2], p[3],
               moved / static_cast<double>(draws));
    for (const double value : p)
      EXPECT_GT(value, 1e-5);
    EXPECT_GT(moved, draws / 2);
  }
}

}  // namespace
}  // namespace sleight::statistical
