// Goal: the measures equal the measures of the R package posterior. Method: compare with stored
// results of posterior 1.4.0 (R 4.2.2) for six arrays x <- outer(0:(draws-1), 0:(chains-1), f). R's
// sprintf("%.17g") printed these results in the order of `measures`. The tests in tests/posterior
// run R and compare more arrays.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "worker/sampling/diagnostics/effective_sample_size.h"
#include "worker/sampling/diagnostics/r_hat.h"

namespace sleight::sampling {
namespace {

constexpr double k_na = std::numeric_limits<double>::quiet_NaN();
using Measures = std::array<double, 6>;

Measures measures(const Chains& draws) {
  return {r_hat(draws),    ess_bulk(draws),           ess_tail(draws),
          ess_mean(draws), ess_quantile(draws, 0.25), mcse_mean(draws)};
}

template <class F>
OwnedChains outer(std::size_t chains, int draws, const F& f) {
  OwnedChains made{.values = {}, .chains = chains, .draws = static_cast<std::size_t>(draws)};
  for (int c = 0; c < static_cast<int>(chains); ++c)
    for (int d = 0; d < draws; ++d)
      made.values.push_back(f(d, c));
  return made;
}

void expect_golden(const OwnedChains& draws, const Measures& golden) {
  const Measures found = measures(draws.view());
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (std::isnan(golden[i])) {
      EXPECT_TRUE(std::isnan(found[i])) << i << ": " << found[i];
    } else {
      EXPECT_NEAR(found[i], golden[i], 1e-10 * std::fabs(golden[i])) << i;
    }
  }
}

TEST(Golden, scattered) {
  // f = ((37*d*d + 11*c + d*c) %% 101)/101
  expect_golden(
      outer(4, 100, [](int d, int c) { return ((37 * d * d + 11 * c + d * c) % 101) / 101.0; }),
      {1.0032775157084368, 336.62621293123732, 395.31409312823962, 336.66896947319418,
       362.60383145630203, 0.01537635528973999});
}

TEST(Golden, rising_in_an_odd_number_of_draws) {
  // f = ((d*d + 7*c*d) %% 61)/61 + d %/% 20
  expect_golden(
      outer(2, 61, [](int d, int c) { return ((d * d + 7 * c * d) % 61) / 61.0 + d / 20; }),
      {1.6250387110420594, 3.682729034802616, 58.874371859296474, 3.3655128720392331,
       5.7166292709754858, 0.50997611337193982});
}

TEST(Golden, short_chains_that_rise_to_their_end) {
  // f = d + (d*d + c) %% 5: the sum of autocorrelations ends at the last lag.
  expect_golden(outer(3, 15, [](int d, int c) { return d + (d * d + c) % 5; }),
                {1.7018115226619348, 13.103844909525414, 31.75679347826086, 12.313318433941273,
                 17.698996655518396, 1.3213920041172225});
}

TEST(Golden, ties) {
  // f = (d*d + c*d) %% 5: the maximum is above the 0.95 quantile, so there is no tail.
  expect_golden(outer(3, 25, [](int d, int c) { return (d * d + c * d) % 5; }),
                {1.0576567708702127, 127.00250479259009, k_na, 124.76125237143344,
                 133.72793974305134, 0.13833165878934037});
}

TEST(Golden, three_draws_are_transposed) {
  // f = (3*d + 2*c + d*c) %% 7: split_in_halves() splits three draws per chain as posterior does.
  expect_golden(outer(4, 3, [](int d, int c) { return (3 * d + 2 * c + d * c) % 7; }),
                {0.87715026984727928, 4, k_na, 4, 4, 1.075730900224108});
}

TEST(Golden, antithetic_is_capped) {
  // f = (-1)^d*(10 + (d*d + c) %% 7): the effective size is capped at 80 log10(80) = 152.247...
  expect_golden(
      outer(2, 40, [](int d, int c) { return (d % 2 == 0 ? 1 : -1) * (10 + (d * d + c) % 7); }),
      {1.0759986249150764, 152.24719895935547, k_na, 152.24719895935547, 152.24719895935547,
       1.0246400973028531});
}

}  // namespace
}  // namespace sleight::sampling
