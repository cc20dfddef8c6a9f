// Tests that proposals for dice leave p_w p_c^beta invariant. The ratio of some proposals depends
// on the candidate's collisions.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <vector>

#include "common/math/elementary.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/support/property.h"
#include "worker/physics/surface/spline_surface.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/worlds/dice/dice.h"

namespace sleight::statistical::dice_invariance_test {

using worlds::dice::ContactShares;
using worlds::dice::Dice;
using worlds::dice::GridIndex;
using worlds::dice::Parameters;
using worlds::dice::State;

constexpr std::uint64_t k_seed = 271828;

bool is_soak() {
  return property::long_run();
}

/// A table with random fields, and one die. Steps are as large as the quantities that they change.
Parameters small_table() {
  Parameters parameters;
  auto& table = parameters.world.table;
  table.columns = 5;
  table.rows = 4;
  table.restitution = {0.3, 0.7};
  table.friction = {0.2, 0.6};
  auto& p = parameters.proposal;
  p.change_all = 0.05;
  p.change_die = 0.05;
  p.change_start = 0.2;
  p.change_control = 0.2;
  p.change_contact = 0.5;
  p.halvings = 2;
  return parameters;
}

/// Dice whose simulation is a formula. The formula gives three collisions. Places of collisions
/// depend on the throw and on the heights of the table's points, so each change shifts the shares
/// of all points.
class Formula {
 public:
  using State = worlds::dice::State;
  struct Outcome {
    ContactShares contacts;
    double end_m = 0;
  };

  explicit Formula(const Parameters& parameters) : parameters_(parameters) {}

  State draw_prior(random::Stream& stream) const {
    return worlds::dice::draw_state(parameters_.world, stream);
  }
  double log_prior(const State& state) const {
    return worlds::dice::log_density_of(parameters_.world, state);
  }
  Outcome simulate(const State& state) const {
    const auto& table = parameters_.world.table;
    const auto height = [&](std::int32_t i, std::int32_t j) {
      return worlds::dice::control_at(parameters_.world, state, {i, j}).height_m /
             table.height_sd_m;
    };
    const auto& die = state.dice[0];
    std::array<math::Vec2, 3> places_m;
    places_m[0] = {0.015 * height(0, 0) + die.position_m.x() + 0.15, 0.015 * height(1, 0)};
    places_m[1] = {places_m[0].x() + 0.01 * height(-1, 0) + 0.05 * (die.velocity_mps.x() - 0.7),
                   places_m[0].y() + 0.01 * height(0, -1)};
    places_m[2] = {places_m[1].x() + 0.01 * height(0, 1), places_m[1].y()};
    const physics::SplineSurface surface({.name = "table",
                                          .controls = std::make_shared<worlds::dice::RandomTable>(
                                              table, 0, worlds::dice::Overrides{}),
                                          .spacing_m = table.spacing_m});
    std::map<GridIndex, double> sums;
    for (const math::Vec2& place_m : places_m) {
      const auto points =
          physics::SplineSurface::support(surface.patch_at(place_m.x(), place_m.y()));
      const auto weights = surface.weights_at(place_m.x(), place_m.y());
      for (std::size_t k = 0; k < points.size(); ++k) {
        if (weights[k] > 0 && worlds::dice::is_on_table(table, points[k]))
          sums[points[k]] += weights[k];
      }
    }
    Outcome outcome{.contacts = {}, .end_m = places_m[2].x()};
    for (const auto& [index, sum] : sums)
      outcome.contacts.push_back({index, sum / 3});
    return outcome;
  }
  double log_constraint(const Outcome& outcome) const {
    const double z = outcome.end_m / 0.02;
    return -0.5 * z * z;
  }
  bool satisfied(const Outcome& outcome) const { return std::fabs(outcome.end_m) < 0.01; }
  sampling::Proposal<State> propose(const State& state, const Outcome& outcome,
                                    std::span<const double> scales, random::Stream& stream) const {
    return worlds::dice::propose(parameters_, state, outcome.contacts, scales, stream);
  }
  double log_q_ratio(const State& state, const Outcome& outcome,
                     const sampling::Proposal<State>& proposal, const Outcome& candidate) const {
    return worlds::dice::contact_log_q_ratio(state, outcome.contacts, proposal.candidate,
                                             candidate.contacts);
  }
  bool has_scale(std::uint32_t kind) const {
    return worlds::dice::has_scale(static_cast<worlds::dice::Kind>(kind));
  }
  std::uint32_t proposal_kinds() const { return worlds::dice::k_kinds; }
  const Parameters& parameters() const { return parameters_; }

  static double end_of(const Outcome& outcome) { return outcome.end_m; }

 private:
  Parameters parameters_;
};

/// A wrong kernel. It treats change_contact as symmetric.
struct Hasty : Formula {
  using Formula::Formula;
  double log_q_ratio(const State& /*state*/, const Outcome& /*outcome*/,
                     const sampling::Proposal<State>& /*proposal*/,
                     const Outcome& /*candidate*/) const {
    return 0;
  }
};

struct Throws : Dice {
  using Dice::Dice;
  static double end_of(const Outcome& outcome) {
    return outcome.at_end.empty() ? 0 : outcome.at_end[0].position_m.x();
  }
};

static_assert(sampling::ProposesByOutcome<Formula>);
static_assert(sampling::ProposesByOutcome<Throws>);

/// Draws by rejection, because p_c is at most 1.
template <class T>
sampling::Sample<T> exact_draw(const T& world, double beta, random::Stream& stream) {
  while (true) {
    sampling::Sample<T> sample = sampling::evaluate(world, world.draw_prior(stream));
    const double u = stream.uniform();
    if (beta == 0 || math::log(u) < beta * sample.log_constraint) return sample;
  }
}

template <class T>
void add(const T& world, const sampling::Sample<T>& sample,
         std::array<std::vector<double>, 14>& values) {
  const auto& die = sample.state.dice[0];
  const auto point = [&](std::int32_t i, std::int32_t j) {
    return worlds::dice::control_at(world.parameters().world, sample.state, {i, j});
  };
  const math::Vec3 axis = math::rotated(die.orientation, math::Vec3(1, 0, 0));
  const auto most =
      std::ranges::max_element(sample.outcome.contacts, {}, &worlds::dice::ContactShare::share);
  const bool has_contact = most != sample.outcome.contacts.end();
  const std::array now{die.position_m.x(),
                       die.position_m.y(),
                       die.velocity_mps.x(),
                       die.spin_radps.z(),
                       axis.x(),
                       axis.z(),
                       point(0, 0).height_m,
                       std::fabs(point(0, 0).height_m),
                       point(-1, 0).height_m,
                       point(0, 0).restitution,
                       point(0, -1).friction,
                       point(1, 1).height_m,
                       T::end_of(sample.outcome),
                       has_contact ? most->share : die.velocity_mps.y()};
  for (std::size_t f = 0; f < now.size(); ++f)
    values[f].push_back(now[f]);
}

struct Run {
  double beta = 0;
  std::uint64_t steps = 1;
  std::size_t chains = 2000;
};

/// Compares moved exact draws with fresh exact draws. Returns the least p-value times the number of
/// tests.
template <class T>
double least_p(const T& world, const Run& run) {
  std::array<std::vector<double>, 14> moved;
  std::array<std::vector<double>, 14> fresh;
  for (std::uint32_t i = 0; i < run.chains; ++i) {
    const auto streams = [&](std::uint32_t chain) {
      return sampling::ChainStreams{
          .seed = k_seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}};
    };
    random::Stream start = streams(2 * i).at(random::Purpose::prior, 0);
    auto sample = exact_draw(world, run.beta, start);
    for (std::uint64_t step = 1; step <= run.steps; ++step)
      sampling::metropolis_hastings_step(world, run.beta, streams(2 * i), step, sample);
    add(world, sample, moved);
    random::Stream other = streams(2 * i + 1).at(random::Purpose::prior, 0);
    add(world, exact_draw(world, run.beta, other), fresh);
  }
  double least = 1;
  for (std::size_t f = 0; f < moved.size(); ++f)
    least = std::min(least, kolmogorov_smirnov_p(moved[f], fresh[f]));
  return static_cast<double>(moved.size()) * least;
}

class DiceInvariance : public testing::TestWithParam<std::tuple<double, std::uint64_t>> {};

TEST_P(DiceInvariance, ProposalsKeepExactDrawsExact) {
  // Goal: proposals for dice, which also change the table's points and the dice's start, leave p_w
  // p_c^beta invariant. Method: make exact draws by rejection, move them with the kernel, and
  // compare them with fresh exact draws. A formula replaces the simulation. The test fails by
  // chance once in 10^4 runs.
  const auto [beta, steps] = GetParam();
  const std::size_t chains = is_soak() ? 100'000 : 4000;
  const double p = least_p(Formula(small_table()), {beta, steps, chains});
  std::printf("beta %g, %d steps: p %g\n", beta, static_cast<int>(steps), p);
  EXPECT_GT(p, 1e-4) << "seed " << k_seed;
}

INSTANTIATE_TEST_SUITE_P(Betas, DiceInvariance,
                         testing::Combine(testing::Values(0.0, 0.5, 1.0),
                                          testing::Values(std::uint64_t{1}, std::uint64_t{20})));

TEST(DiceInvarianceOfAHastyRatio, IsRefuted) {
  // Goal: the invariance test rejects a kernel that omits the ratio of change_contact. Method: move
  // exact draws with the wrong kernel. Compare them with fresh exact draws. Repeat with the right
  // kernel.
  Parameters parameters = small_table();
  parameters.proposal.change_all = 0;
  parameters.proposal.change_die = 0;
  parameters.proposal.change_start = 0;
  parameters.proposal.change_control = 0;
  parameters.proposal.change_contact = 1;
  parameters.proposal.halvings = 0;
  parameters.proposal.height_m = 0.003;
  const double p = least_p(Hasty(parameters), {0, 40, 20'000});
  std::printf("hasty, 40 steps: p %g\n", p);
  EXPECT_LT(p, 1e-9);
  const double right = least_p(Formula(parameters), {0, 40, 20'000});
  std::printf("contacts alone, 40 steps: p %g\n", right);
  EXPECT_GT(right, 1e-4);
}

TEST(DiceInvarianceOfThrows, Holds) {
  // Goal: the kernel leaves its target invariant with real simulations that reuse similar
  // simulations. The target stays invariant even if a goal names a face, although the faces are
  // numbered after the simulation. Method: use a table of a few points and wide goals, so that
  // exact draws are cheap. Compare moved exact draws with fresh exact draws.
  Parameters parameters = small_table();
  parameters.world.dice[0].position_m.x() = -0.03;
  parameters.world.dice[0].velocity_mps.x() = 0.2;
  parameters.goals = {
      {.wanted = worlds::dice::Place{.centre_m = {0, 0}}, .sigma = 0.03, .tolerance = 0.03},
      {.wanted = worlds::dice::FaceDirection{.face = 6}, .sigma = 0.5, .tolerance = 0.3}};
  const std::size_t chains = is_soak() ? 20'000 : 600;
  for (const double beta : {0.0, 1.0}) {
    const double p = least_p(Throws(parameters), {beta, 10, chains});
    std::printf("throws, beta %g: p %g\n", beta, p);
    EXPECT_GT(p, 1e-4) << "seed " << k_seed;
  }
}

}  // namespace sleight::statistical::dice_invariance_test
