// Goal: if a request's cost exceeds a limit, the request is refused, and the error shows how the
// cost is computed.
#include "service/daemon/request_cost.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/facts.h"

namespace sleight::daemon {
namespace {

using request::Method;
using ::testing::HasSubstr;

request::DirectionRequest request_with(Method method, std::uint32_t chains) {
  request::DirectionRequest made;
  made.sampler = {.method = method, .chains = chains, .iterations_per_scan = 10};
  return made;
}

TEST(RequestCostTest, StatesAreChainsTimesTemperaturesOrParticles) {
  EXPECT_EQ(cost_of(request_with(Method::metropolis_hastings, 7)).states, 7U);
  auto tempered = request_with(Method::parallel_tempering, 65536);
  EXPECT_EQ(cost_of(tempered).states, 65536U * 64U);
  EXPECT_THAT(cost_of(tempered).states_sum, tests::HasFacts("65,536 chains|64|= 4,194,304 states"));
  tempered.sampler.replicas = 5;
  EXPECT_EQ(cost_of(tempered).states, 65536U * 5U);
  auto islands = request_with(Method::sequential, 10);
  EXPECT_EQ(cost_of(islands).states, 640U);
  islands.sampler.particles = 4096;
  EXPECT_EQ(cost_of(islands).states, 40960U);
  EXPECT_EQ(cost_of(request_with(Method::search, 0)).states, 0U);
}

TEST(RequestCostTest, SimulationsFollowFromScansAndRounds) {
  auto asked = request_with(Method::metropolis_hastings, 4);
  EXPECT_FALSE(cost_of(asked).simulations.has_value());
  asked.stop.scans = 1000;
  EXPECT_EQ(cost_of(asked).simulations, 40'000U);
  EXPECT_THAT(cost_of(asked).simulations_sum,
              tests::HasFacts("4 chains|10|1,000 scans|= 40,000 simulations"));
  auto small = request_with(Method::metropolis_hastings, 1);
  small.sampler.iterations_per_scan = 1;
  small.stop.scans = 7;
  EXPECT_THAT(cost_of(small).simulations_sum,
              tests::HasFacts("1 chain |1|7 scans|= 7 simulations"));
  asked.stop.scans.reset();
  asked.stop.rounds = 3;
  EXPECT_EQ(cost_of(asked).simulations, 4U * 10U * 64U * 7U);
  // If a product would overflow, it becomes the largest 64-bit number.
  asked = request_with(Method::sequential, 65536);
  asked.sampler.particles = 4096;
  asked.sampler.iterations_per_scan = 4'000'000'000U;
  asked.stop.scans = request::k_scans_max;
  EXPECT_EQ(cost_of(asked).simulations, UINT64_MAX);
}

TEST(RequestCostTest, TheRefusalShowsTheSumAndTheLimit) {
  const RequestCost cost = cost_of(request_with(Method::parallel_tempering, 65536));
  const auto refusal = beyond_limits(cost, {.states = 16384});
  ASSERT_TRUE(refusal.has_value());
  EXPECT_EQ(refusal->kind, rpc::RefusalKind::limit);
  EXPECT_THAT(refusal->sentence, HasSubstr("= 4,194,304 states"));
  EXPECT_THAT(refusal->sentence, HasSubstr("16,384 states"));
  EXPECT_FALSE(beyond_limits(cost, {}).has_value());
  EXPECT_FALSE(beyond_limits(cost, {.states = 4'194'304}).has_value());
  auto asked = request_with(Method::metropolis_hastings, 4);
  asked.stop.scans = 1000;
  EXPECT_TRUE(beyond_limits(cost_of(asked), {.simulations = 39'999}).has_value());
  EXPECT_FALSE(beyond_limits(cost_of(asked), {.simulations = 40'000}).has_value());
}

}  // namespace
}  // namespace sleight::daemon
