// Geweke's test ("Getting it right", 2004). The test treats the constraint as a datum: the landing
// place, observed with noise sigma_d. So the test covers prior, kernel and simulator as one joint
// model.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "common/random/distributions.h"
#include "tests/statistical/support/ball_fixture.h"
#include "tests/statistical/support/broken_kernels.h"
#include "tests/statistical/support/rank_tests.h"

namespace sleight::statistical::geweke_test {

constexpr std::uint64_t k_seed = 979323;
constexpr std::size_t k_functions = 8;

/// The constraint is wide, so that single kernel steps change the state. The test is about
/// correctness, not mixing.
worlds::ball_2d::Parameters parameters_with_datum(double datum_diameters) {
  worlds::ball_2d::Parameters parameters;
  parameters.constraint.sigma_diameters = 1;
  parameters.constraint.target_diameters = datum_diameters;
  return parameters;
}

double draw_datum(double landing_x_m, random::Stream& stream) {
  const worlds::ball_2d::Parameters parameters = parameters_with_datum(0);
  return random::Normal{.mean = landing_x_m / parameters.world.diameter_m,
                        .sd = parameters.constraint.sigma_diameters}
      .draw(stream);
}

std::array<double, k_functions> functions(const BallSample& sample, double datum) {
  const auto& n = sample.state;
  const double x_diameters = sample.outcome.x_m / parameters_with_datum(0).world.diameter_m;
  const double residual = datum - x_diameters;
  return {n[0],  n[0] * n[0],   n[2] * n[2],         n[4] * n[4],
          datum, datum * datum, datum * x_diameters, residual * residual};
}

/// Draws (normals, datum) in two ways, and compares the means of all functions. Returns the largest
/// |z|.
double largest_z(Bug bug) {
  constexpr std::size_t k_independent = 100000;
  constexpr std::uint64_t k_steps = 100000;
  const Ball prior_ball{parameters_with_datum(0)};

  // Marginal-conditional: draw normals from the prior, then the datum given the landing place.
  std::array<std::vector<double>, k_functions> independent;
  for (std::uint32_t i = 0; i < k_independent; ++i) {
    random::Stream stream = streams_of(k_seed, 10 + i).at(random::Purpose::prior, 0);
    const BallSample sample = sampling::evaluate(prior_ball, prior_ball.draw_prior(stream));
    const auto values = functions(sample, draw_datum(sample.outcome.x_m, stream));
    for (std::size_t f = 0; f < k_functions; ++f)
      independent[f].push_back(values[f]);
  }

  // Successive-conditional: draw the datum given the landing place, then make one kernel step given
  // the datum.
  std::array<std::vector<std::vector<double>>, k_functions> successive;
  for (auto& series : successive)
    series.resize(1);
  const sampling::ChainStreams streams = streams_of(k_seed, 1);
  BallSample sample = sampling::draw_afresh(prior_ball, streams, 0);
  for (std::uint64_t iteration = 1; iteration <= k_steps; ++iteration) {
    random::Stream datum_stream = streams_of(k_seed, 2).at(random::Purpose::prior, iteration);
    const double datum = draw_datum(sample.outcome.x_m, datum_stream);
    const Ball ball{parameters_with_datum(datum)};
    sample = sampling::evaluate(ball, sample.state);
    step(ball, bug, 1.0, streams, iteration, sample);
    const auto values = functions(sample, datum);
    for (std::size_t f = 0; f < k_functions; ++f)
      successive[f][0].push_back(values[f]);
  }

  double largest = 0;
  for (std::size_t f = 0; f < k_functions; ++f) {
    const MeanWithError a = mean_of_independent(independent[f]);
    const MeanWithError b = mean_of_chains(successive[f]);
    const double error = std::hypot(a.standard_error, b.standard_error);
    largest = std::max(largest, std::abs(a.mean - b.mean) / error);
  }
  return largest;
}

TEST(Geweke, BothWaysToDrawTheJointAgree) {
  // Goal: prior, proposal, acceptance, simulator and constraint belong to one joint density.
  // Method: draw (normals, datum) in two ways, and compare the means of 8 functions. Standard
  // errors include autocorrelation. By chance, any of the 8 differences exceeds 4.5 standard errors
  // once in 18,000 runs.
  EXPECT_LT(largest_z(Bug::none), 4.5) << "seed " << k_seed;
}

TEST(Geweke, ABrokenKernelDisagrees) {
  // Goal: Geweke's test rejects wrong kernels. Method: run the test with each of five bugs of
  // different kinds.
  for (const Bug bug : {Bug::prior_forgotten, Bug::ratio_inverted, Bug::constraint_forgotten,
                        Bug::wrong_temperature, Bug::independence_draw_as_symmetric}) {
    EXPECT_GT(largest_z(bug), 6) << name_of(bug);
  }
}

}  // namespace sleight::statistical::geweke_test
