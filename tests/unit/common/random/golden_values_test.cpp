// Goal: streams and distributions always return the same numbers. A change would alter the results
// of every run, so its commit must name the cause. Method: compare the first draws of one stream
// with stored hexadecimal values.
#include <gtest/gtest.h>

#include <bit>
#include <vector>

#include "common/random/distributions.h"

namespace sleight::random {
namespace {

Stream golden_stream() {
  return Stream({.seed = 42,
                 .chain = base::ChainId{3},
                 .replica = base::ReplicaId{5},
                 .purpose = Purpose::proposal},
                1000);
}

template <class D>
std::vector<double> first_draws(const D& distribution) {
  Stream stream = golden_stream();
  std::vector<double> result;
  for (int i = 0; i < 2; ++i) {
    const auto x = distribution.draw(stream);
    if constexpr (requires { x.coeffs(); }) {
      result.insert(result.end(), {x.w(), x.x(), x.y(), x.z()});
    } else if constexpr (requires { x.size(); }) {
      result.insert(result.end(), x.begin(), x.end());
    } else {
      result.push_back(static_cast<double>(x));
    }
  }
  return result;
}

void expect_bits(const char* what, const std::vector<double>& values,
                 const std::vector<double>& golden) {
  ASSERT_EQ(values.size(), golden.size()) << what;
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(values[i]), std::bit_cast<std::uint64_t>(golden[i]))
        << what << " " << i << ": " << std::hexfloat << values[i] << " against " << golden[i];
  }
}

TEST(GoldenValues, stream) {
  Stream stream = golden_stream();
  const std::vector<std::uint64_t> golden = {0x23cd2a3702afb066, 0x4def623960309015,
                                             0x7f5e172fec8f84f9, 0xc104baa3f2c2ae01,
                                             0xd7def61960c56d21};
  for (const std::uint64_t word : golden)
    EXPECT_EQ(stream.bits(), word) << std::hex << word;
}

TEST(GoldenValues, draws) {
  expect_bits("uniform", first_draws(Uniform{.low = -1, .high = 3}),
              {-0x1.c32d5c8fd5048p-2, 0x1.bdec472c0613p-3});
  expect_bits("normal", first_draws(Normal{.mean = 1, .sd = 2}),
              {-0x1.5270be2b6b138p-2, 0x1.0f1f0b25994e4p+0});
  expect_bits("truncated normal, centre",
              first_draws(TruncatedNormal{.mean = 0, .sd = 1, .low = -2, .high = 3}),
              {-0x1.549c2f8adac4ep-1, 0x1.e3e164b329c74p-6});
  expect_bits("truncated normal, short",
              first_draws(TruncatedNormal{.mean = 0, .sd = 1, .low = -1, .high = 1}),
              {-0x1.70cb5723f5412p-1, -0x1.43d1a026e0fp-8});
  expect_bits("truncated normal, tail", first_draws(TruncatedNormal{.mean = 0, .sd = 1, .low = 8}),
              {0x1.0097ece5aac18p+3, 0x1.02b60e242b714p+3});
  expect_bits(
      "direction in the plane", first_draws(UniformDirection2{}),
      {0x1.46bc041263296p-1, 0x1.8a3190e04b8a8p-1, -0x1.57705720e19f1p-2, 0x1.e258407ffe68p-1});
  expect_bits("direction in space", first_draws(UniformDirection3{}),
              {-0x1.dc75de483f8fcp-3, 0x1.4e95779ef1467p-1, -0x1.70cb5723f5412p-1,
               0x1.99812dea632cdp-6, -0x1.ffd573c067662p-1, -0x1.43d1a026e0fp-8});
  expect_bits(
      "rotation", first_draws(UniformRotation{}),
      {-0x1.7ee4b1a1a51f7p-2, 0x1.bf58e7fdbf208p-1, -0x1.3e851caa5d7b4p-2, 0x1.7c6bd50ef2aeap-8,
       -0x1.00c4d028884f9p-1, -0x1.a734074352779p-2, 0x1.18d72779a1895p-2, 0x1.6aeef7779ab14p-1});
  expect_bits("bernoulli", first_draws(Bernoulli{.p = 0.5}), {0x1p+0, 0x1p+0});
  expect_bits("uniform integer", first_draws(UniformInteger{.count = 1000000}),
              {0x1.11248p+17, 0x1.294c4p+18});
}

TEST(GoldenValues, log_densities) {
  expect_bits(
      "log densities",
      {Uniform{.low = -1, .high = 3}.log_density(0.3), Normal{.mean = 1, .sd = 2}.log_density(0.3),
       TruncatedNormal{.mean = 0, .sd = 1, .low = -2, .high = 3}.log_density(0.3),
       TruncatedNormal{.mean = 0, .sd = 1, .low = 8, .high = 8.25}.log_density(8.1),
       TruncatedNormal{.mean = 0, .sd = 1, .low = 2}.log_density(2.1)},
      {-0x1.62e42fefa39efp+0, -0x1.ac5fbab5d90cdp+0, -0x1.e10bd34d7b026p-1, 0x1.6cf8b93ca3dbap+0,
       0x1.5188aa6226b5p-1});
}

}  // namespace
}  // namespace sleight::random
