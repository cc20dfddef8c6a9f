// Goal: moves of users' scenes leave p_w p_c^beta invariant, a chain has the right proportions, and
// a die of a scene falls as one of world dice. Method: compare exact draws after some steps with
// fresh ones, a chain with an enumeration, and throws of both worlds.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "common/math/island_odds.h"
#include "common/random/discrete_distributions.h"
#include "common/request/direction_request.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/support/property.h"
#include "worker/sampling/surrogate_transition.h"
#include "worker/worlds/dice/dice.h"
#include "worker/worlds/user_scene/request.h"
#include "worker/worlds/user_scene/scene_search.h"

namespace sleight::statistical::scene_invariance_test {

using worlds::user_scene::address_of;
using worlds::user_scene::State;
using worlds::user_scene::UserScene;
using Outcome = worlds::user_scene::Outcome;

UserScene scene_of(const std::string& text) {
  const std::vector<request::WorldBinding> worlds{worlds::user_scene::request_binding()};
  const auto request =
      request::read_request("[world]\nname = \"scene\"\n" + text, "s.toml", worlds);
  if (!request) base::check_failed("no errors", to_string(request.error().front()));
  return UserScene(request::parameters_of<worlds::user_scene::Parameters>(request.value()));
}

/// Two balls that bounce and may hit each other, with every sort of number.
const std::string k_balls = R"(end_s = 0.5
[[world.material]]
name = "rubber"
restitution = 0.6
[[world.body]]
name = "floor"
shape = "plane"
[[world.body]]
name = "ball"
radius_mm = 10
at_mm = [0, 0, 60]
row = {count = 2, step_mm = [25, 0, 0]}
[[world.uncertain]]
body = "ball"
quantity = "position_mm"
normal_sd = [2, 2, 0]
[[world.uncertain]]
body = "ball"
quantity = "velocity_mps"
within = [0.2, 0.2, 0.2]
[[world.uncertain]]
body = "ball 2"
quantity = "start_s"
normal_sd = [0.05]
within = [0.1]
[[world.uncertain]]
material = "rubber"
quantity = "restitution"
choices = [0.5, 0.6, 0.7]
[[constraint.place]]
body = "ball"
at_mm = [20, 10]
at_s = 0.4
sigma_mm = 25
)";

/// Treats all moves as symmetric, so the chain forgets the prior of normals.
struct Forgetful : UserScene {
  using UserScene::UserScene;
  explicit Forgetful(const UserScene& world) : UserScene(world) {}
  using UserScene::propose;
  sampling::Proposal<State> propose(const State& state, const Outcome& outcome,
                                    std::span<const double> scales, random::Stream& stream) const {
    auto proposal = UserScene::propose(state, outcome, scales, stream);
    proposal.log_q_ratio = 0;
    return proposal;
  }
};

enum class Mistake {
  none,
  no_ratio,        ///< shots without N / N'
  inverted_ratio,  ///< shots with N' / N
  grows,           ///< shots that step without shrinking
  positive,        ///< shots whose first value is never negative
  bounded,         ///< shots that never make the third value large
  last_impact,     ///< shots at the last impact
  first_time,      ///< tails from an impact chosen evenly, without a ratio
  from_the_end,    ///< tails from the second half of the present simulation
  better_key       ///< tails that choose the smaller of two keys' first values
};

/// Makes only shots and tails, with a mistake.
struct Mistaken : UserScene {
  Mistaken(const UserScene& world, Mistake what) : UserScene(world), mistake(what) {}
  using UserScene::propose;

  sampling::Proposal<State> propose(const State& state, const Outcome& outcome,
                                    std::span<const double> /*scales*/,
                                    random::Stream& stream) const {
    using worlds::user_scene::with_fresh_tail;
    sampling::Proposal<State> proposal{.candidate = state};
    State& candidate = proposal.candidate;
    const std::vector<physics::Impact>& noised = outcome.noised;
    if (noised.empty()) return proposal;
    const auto evenly = random::UniformInteger{.count = noised.size()}.draw(stream);
    const bool shoots =
        mistake == Mistake::none ? stream.uniform() < 0.5 : mistake <= Mistake::last_impact;
    if (shoots) {
      const auto address =
          address_of(noised[mistake == Mistake::last_impact ? noised.size() - 1 : evenly]);
      worlds::user_scene::step_noise(candidate.noise, address, 0.6, stream);
      physics::NoiseValue value = candidate.noise.at(address);
      if (mistake == Mistake::grows)
        for (double& part : value)
          part *= 1.25;
      if (mistake == Mistake::positive) value[0] = std::fabs(value[0]);
      if (mistake == Mistake::bounded && std::fabs(value[2]) > 1) value = state.noise.at(address);
      candidate.noise.set(address, value);
      proposal.ratio_waits = true;
      proposal.log_q_ratio = 1e9;  // no early rejection
      return proposal;
    }
    const double end_s = parameters().scene.end_s;
    double from_s = end_s * stream.uniform();
    if (mistake == Mistake::first_time)
      from_s = physics::seconds(noised[evenly].tick - physics::Tick{});
    if (mistake == Mistake::from_the_end)
      from_s = physics::seconds(noised[noised.size() / 2].tick - physics::Tick{});
    const physics::Tick from = physics::Tick{} + physics::ticks_after(from_s);
    candidate.noise = with_fresh_tail(state.noise, noised, from, stream);
    if (mistake == Mistake::better_key) {
      const auto other = with_fresh_tail(state.noise, noised, from, stream);
      const auto address = address_of(noised.back());
      if (other.at(address)[2] < candidate.noise.at(address)[2]) candidate.noise = other;
    }
    proposal.log_q_ratio = log_prior(state) - log_prior(candidate);
    return proposal;
  }
  double log_q_ratio(const State& state, const Outcome& outcome,
                     const sampling::Proposal<State>& proposal,
                     const Outcome& candidate_outcome) const {
    const double ratio =
        worlds::user_scene::shot_log_ratio(outcome.noised, candidate_outcome.noised);
    const double counted = mistake == Mistake::no_ratio || mistake == Mistake::last_impact ? 0
                           : mistake == Mistake::inverted_ratio                            ? -ratio
                                                                                           : ratio;
    return log_prior(state) - log_prior(proposal.candidate) + counted;
  }

  Mistake mistake;
};

/// Draws from p_w p_c^beta by rejection: p_c <= 1.
template <class World>
sampling::Sample<World> exact_draw(const World& world, double beta, random::Stream& stream) {
  for (;;) {
    auto sample = sampling::evaluate(world, world.draw_prior(stream));
    if (std::log(stream.uniform()) < beta * sample.log_constraint) return sample;
  }
}

/// Compares exact draws after some steps with fresh exact draws. Returns the least p-value of any
/// number or distance.
template <class World>
double least_p(const World& world, double beta, int steps) {
  const std::size_t count = property::long_run() ? 4000 : 500;
  random::Stream stream({.seed = 20261130, .purpose = random::Purpose::search}, 0);
  const sampling::ChainStreams streams{.seed = 4711, .chain = {}, .replica = {}};
  std::vector<std::vector<double>> moved;
  std::vector<std::vector<double>> fresh;
  const auto add = [&](const sampling::Sample<World>& sample, auto& to) {
    std::vector<double> values = sample.state.numbers;
    // The log prior counts overrides, which exact draws don't have.
    values.push_back(world.quantities().log_density(sample.state.numbers));
    if (world.has_noise()) {
      const std::vector<physics::Impact>& noised = sample.outcome.noised;
      values.push_back(static_cast<double>(noised.size()));
      for (const bool last : {false, true}) {
        physics::NoiseValue value{};
        if (!noised.empty())
          value = sample.state.noise.at(address_of(last ? noised.back() : noised.front()));
        values.insert(values.end(), value.begin(), value.end());
      }
      double squares = 0;
      for (const physics::Impact& impact : noised)
        squares += std::pow(sample.state.noise.at(address_of(impact))[2], 2);
      values.push_back(squares);
    }
    values.insert(values.end(), sample.outcome.judgement.distances.begin(),
                  sample.outcome.judgement.distances.end());
    to.resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      to[i].push_back(values[i]);
  };
  for (std::size_t n = 0; n < count; ++n) {
    auto sample = exact_draw(world, beta, stream);
    for (int step = 0; step < steps; ++step)
      sampling::iterate(world, beta, streams, n * 100 + static_cast<std::size_t>(step), sample, {},
                        [](const sampling::StepReport&) {});
    add(sample, moved);
    add(exact_draw(world, beta, stream), fresh);
  }
  double least = 1;
  for (std::size_t i = 0; i < moved.size(); ++i)
    least = std::min(least, kolmogorov_smirnov_p(moved[i], fresh[i]));
  return least;
}

/// A ball that bounces on a floor and a block, with noise.
const std::string k_noised = R"(end_s = 0.8
[world.contact_noise]
above_mps = 0.3
tilt_sd_deg = 8
restitution_sd = 0.15
[[world.material]]
name = "rubber"
restitution = 0.6
[[world.body]]
name = "floor"
shape = "plane"
[[world.body]]
name = "block"
shape = "box"
size_mm = [40, 400, 30]
at_mm = [40, 0, 15]
static = true
[[world.body]]
name = "ball"
radius_mm = 10
at_mm = [0, 0, 100]
velocity_mps = [0.1, 0, 0]
[[world.uncertain]]
body = "ball"
quantity = "velocity_mps"
normal_sd = [0.1, 0, 0]
[[constraint.place]]
body = "ball"
at_mm = [20, 10]
at_s = 0.5
sigma_mm = 40
)";

class SceneInvariance : public testing::TestWithParam<double> {};
// 15 values are compared: 0.0005 each makes a false alarm rarer than 1%.
TEST_P(SceneInvariance, TenStepsKeepExactDrawsExact) {
  EXPECT_GT(least_p(scene_of(k_balls), GetParam(), 10), 0.0005);
}
TEST_P(SceneInvariance, AlsoWithContactNoise) {
  EXPECT_GT(least_p(scene_of(k_noised), GetParam(), 10), 0.0005);
  EXPECT_GT(least_p(Mistaken(scene_of(k_noised), Mistake::none), GetParam(), 10), 0.0005);
}
INSTANTIATE_TEST_SUITE_P(Betas, SceneInvariance, testing::Values(0.3, 1.0));

class SceneInvarianceOf : public testing::TestWithParam<Mistake> {};
TEST_P(SceneInvarianceOf, MistakesIsBroken) {
  EXPECT_LT(least_p(Mistaken(scene_of(k_noised), GetParam()), 0.3, 30), 0.0005);
}
INSTANTIATE_TEST_SUITE_P(All, SceneInvarianceOf,
                         testing::Values(Mistake::no_ratio, Mistake::inverted_ratio, Mistake::grows,
                                         Mistake::positive, Mistake::bounded, Mistake::last_impact,
                                         Mistake::first_time, Mistake::from_the_end,
                                         Mistake::better_key));

TEST(SceneInvarianceOfForgetfulMoves, IsRejected) {
  EXPECT_LT(least_p(Forgetful(scene_of(k_balls)), 0.3, 10), 0.0005);
}

/// Two stages: the second bounce, then a place.
const std::string k_second_bounce = k_noised + R"(tolerance_mm = 60
[[constraint.event]]
name = "second bounce"
body = "ball"
hits = "floor"
nth = 2
at_s = 0.33
tolerance_s = 0.02
sigma_s = 0.01
window_s = 0.1
)";

TEST(SceneOdds, StoppingEarlyChangesNoCandidateWithinALevel) {
  const UserScene world = scene_of(k_second_bounce);
  random::Stream stream({.seed = 5, .purpose = random::Purpose::search}, 0);
  int stopped = 0;
  for (int n = 0; n < 300; ++n) {
    const State state = world.draw_prior(stream);
    const Outcome outcome = world.simulate_stages(state, 2, {});
    const State candidate = world.propose(state, outcome, {}, stream).candidate;
    const Outcome early = world.simulate_from(candidate, state, outcome, 2U);
    const Outcome whole = world.simulate_stages(candidate, 2, {});
    EXPECT_EQ(world.progress(early), world.progress(whole));
    stopped += early.end_s < whole.end_s ? 1 : 0;
    if (world.progress(whole).passed == 0) continue;
    EXPECT_EQ(early.end_s, whole.end_s);
    EXPECT_EQ(early.judgement.distances, whole.judgement.distances);
    EXPECT_EQ(early.noised.size(), whole.noised.size());
  }
  EXPECT_GT(stopped, 30);
}

TEST(SceneOdds, OfSplittingAgreeWithRejection) {
  const UserScene world = scene_of(k_second_bounce);
  ASSERT_EQ(world.stages(), 2U);
  const std::uint64_t throws = property::long_run() ? 400'000 : 40'000;
  random::Stream stream({.seed = 20261201, .purpose = random::Purpose::search}, 0);
  double satisfied = 0;
  for (std::uint64_t n = 0; n < throws; ++n)
    satisfied += world.satisfied(world.simulate(world.draw_prior(stream))) ? 1 : 0;

  const auto tell_nobody = [](const auto&) {};
  const sampling::ChainStreams streams{.seed = 11, .chain = {}, .replica = {}};
  const sampling::Splitting<UserScene> splitting(world, 32, streams);
  const auto levels = splitting.find_levels(tell_nobody);
  EXPECT_GT(levels.size(), 3U);
  math::IslandSums sums;
  for (std::uint64_t number = 1; number <= 200; ++number)
    sums.add(splitting.island(levels, number, tell_nobody).estimate.log_satisfied);
  const math::IslandOdds odds = sums.odds();
  const double log = std::log(satisfied / static_cast<double>(throws));
  EXPECT_LT(odds.log_error(), 0.15);
  EXPECT_NEAR(odds.log_mean, log, 2 * std::hypot(odds.log_error(), 1 / std::sqrt(satisfied)));
}

TEST(SceneProportions, AgreeWithAnEnumeration) {
  // A ball falls into one of two bins: it starts at one of four places, and a wedge parts them.
  const UserScene world = scene_of(R"(end_s = 2
[[world.body]]
name = "floor"
shape = "plane"
[[world.body]]
name = "wedge"
shape = "hull"
points_mm = [[-20, -50, 0], [20, -50, 0], [0, -50, 40], [-20, 50, 0], [20, 50, 0], [0, 50, 40]]
static = true
[[world.body]]
name = "ball"
radius_mm = 5
at_mm = [0, 0, 100]
[[world.uncertain]]
body = "ball"
quantity = "position_mm"
choices = [-12, 0, 100, -4, 0, 100, 3, 0, 100, 15, 0, 100]
shares = [4, 3, 2, 1]
[[world.region]]
name = "right"
low_mm = [0, -100, 0]
high_mm = [500, 100, 100]
[[constraint.region]]
body = "ball"
region = "right"
at_s = 0.3
sigma_mm = 20
)");
  const std::array<double, 4> shares{0.4, 0.3, 0.2, 0.1};
  const std::array<double, 4> middles{0.2, 0.55, 0.8, 0.95};
  std::array<double, 4> exact{};
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i)
    sum += exact[i] = shares[i] * std::exp(world.log_constraint(world.simulate({{middles[i]}})));
  EXPECT_EQ(world.simulate({{middles[3]}}).judgement.distances[0], 0);
  EXPECT_GT(world.simulate({{middles[0]}}).judgement.distances[0], 0.01);
  // Chains of independent starts; each series tells which choice is present.
  constexpr std::size_t k_chains = 8;
  const std::size_t scans = property::long_run() ? 20'000 : 2000;
  for (std::size_t choice = 0; choice < 4; ++choice) {
    std::vector<std::vector<double>> chains;
    for (std::uint32_t chain = 0; chain < k_chains; ++chain) {
      random::Stream stream({.seed = chain, .purpose = random::Purpose::search}, choice);
      auto sample = exact_draw(world, 1, stream);
      std::vector<double>& series = chains.emplace_back();
      for (std::size_t scan = 0; scan < scans; ++scan) {
        sampling::iterate(world, 1, {.seed = 1, .chain = base::ChainId{chain}, .replica = {}}, scan,
                          sample, {}, [](const sampling::StepReport&) {});
        const double u = sample.state.numbers[0];
        const std::size_t now = u < 0.4 ? 0 : u < 0.7 ? 1 : u < 0.9 ? 2 : 3;
        series.push_back(now == choice ? 1 : 0);
      }
    }
    const MeanWithError mean = mean_over_independent_chains(chains);
    EXPECT_NEAR(mean.mean, exact[choice] / sum, 4.5 * mean.standard_error + 1e-3) << choice;
  }
}

TEST(SceneDie, FallsAsADieOfWorldDice) {
  // World dice, flat table: laws between die and table are those of the table.
  worlds::dice::Parameters parameters;
  parameters.world.table.height_sd_m = 0;
  const worlds::dice::Dice dice(parameters);
  const UserScene scene = scene_of(R"(end_s = 6
[[world.material]]
name = "die"
density_kgpm3 = 1200
restitution = 0.5
friction = 0.4
[[world.body]]
name = "table"
shape = "plane"
[[world.body]]
name = "die"
shape = "box"
size_mm = [16, 16, 16]
at_mm = [-150, 0, 100]
velocity_mps = [0.7, 0, 0]
[[world.uncertain]]
body = "die"
quantity = "position_mm"
normal_sd = [5, 5, 0]
[[world.uncertain]]
body = "die"
quantity = "orientation"
[[world.uncertain]]
body = "die"
quantity = "velocity_mps"
normal_sd = [0.1, 0.1, 0]
[[world.uncertain]]
body = "die"
quantity = "spin_radps"
normal_sd = [20, 20, 20]
[[constraint.face]]
body = "die"
up = 6
)");
  const bool is_long = property::long_run();
  const int throws = is_long ? 60'000 : 1000;
  random::Stream stream({.seed = 31, .purpose = random::Purpose::search}, 0);
  struct Sums {
    int sixes = 0;
    math::Vec3 place_m = math::Vec3::Zero();
  };
  Sums of_dice;
  Sums of_scene;
  for (int n = 0; n < throws; ++n) {
    const auto thrown = dice.simulate(dice.draw_prior(stream));
    ASSERT_EQ(thrown.end, worlds::dice::End::settled);
    const auto& end = thrown.at_end.front();
    of_dice.sixes += math::matrix_of(end.orientation)(2, 0) < -0.99 ? 1 : 0;
    of_dice.place_m += end.position_m;
    const auto animation = scene.animate(scene.draw_prior(stream));
    ASSERT_EQ(animation.outcome.end, worlds::user_scene::End::settled);
    of_scene.sixes += animation.outcome.judgement.all_met ? 1 : 0;
    const auto& last = animation.recording.segments({0}).back().segment;
    of_scene.place_m += physics::position_at(last.flight, animation.recording.end());
  }
  const double share = (of_scene.sixes - of_dice.sixes) / static_cast<double>(throws);
  const math::Vec3 apart_m = (of_scene.place_m - of_dice.place_m) / throws;
  EXPECT_LT(std::fabs(share), is_long ? 0.01 : 0.07);
  EXPECT_LT(math::norm(apart_m), is_long ? 0.002 : 0.02);
}

}  // namespace sleight::statistical::scene_invariance_test
