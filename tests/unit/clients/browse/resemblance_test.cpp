// Goal: the resemblance of two animations is the stated distance. Method: compare known cases with
// the plain formula. Compare the cheapest matching of bodies with the cheapest of all permutations.
#include "clients/browse/resemblance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tests/support/property.h"
#include "tests/unit/clients/browse/random_index.h"

namespace sleight::browse {
namespace {

using testing::entries_of;
using testing::random_index;

constexpr std::uint64_t k_seed = 27;

TEST(Resemblance, MatchesBodiesAsCheaplyAsAllPermutationsAllow) {
  CheapestMatching matching;  // one object for all sizes, as in use
  for (const std::uint64_t n : property::cases(400)) {
    random::Stream stream = testing::stream_of(k_seed, n);
    const std::size_t size = 1 + testing::below(stream, 6);
    std::vector<double> costs;
    // If there are few different costs, many matchings are equally cheap.
    const bool is_coarse = n % 2 == 0;
    for (std::size_t i = 0; i < size * size; ++i)
      costs.push_back(is_coarse ? static_cast<double>(testing::below(stream, 4))
                                : stream.uniform());
    const auto cost_of = [&](const std::vector<std::uint32_t>& column) {
      double sum = 0;
      for (std::size_t row = 0; row < size; ++row)
        sum += costs[row * size + column[row]];
      return sum;
    };
    std::vector<std::uint32_t> order(size);
    std::iota(order.begin(), order.end(), 0U);
    double least = cost_of(order);
    while (std::ranges::next_permutation(order).found)
      least = std::min(least, cost_of(order));
    const auto columns = matching.of(costs, size);
    std::vector<std::uint32_t> found(columns.begin(), columns.end());
    EXPECT_NEAR(cost_of(found), least, 1e-12);
    std::ranges::sort(found);
    std::iota(order.begin(), order.end(), 0U);
    EXPECT_EQ(found, order);
  }
}

TEST(Resemblance, IsSymmetricAndZeroOfOneself) {
  random::Stream stream = testing::stream_of(k_seed, 0);
  const Index index = random_index(12, stream);
  const std::vector<const Entry*> entries = entries_of(index);
  const Sketches sketches(entries, index.scene);
  const std::vector<float> one = sketches.matrix(1);
  for (std::size_t a = 0; a < entries.size(); ++a) {
    EXPECT_EQ(sketches.between(a, a).value_m(), 0);
    for (std::size_t b = 0; b < entries.size(); ++b) {
      EXPECT_EQ(sketches.between(a, b).value_m(), sketches.between(b, a).value_m());
      EXPECT_EQ(one[a * entries.size() + b], static_cast<float>(sketches.between(a, b).value_m()));
      if (a != b) {
        EXPECT_GT(one[a * entries.size() + b], 0);
      }
    }
  }
  EXPECT_EQ(one, sketches.matrix(3));
}

/// Returns animations that differ only in the paths of the two twin balls. Each path is straight
/// and takes 1 s.
Index two_ways(const std::vector<std::vector<math::Vec3>>& ways) {
  Index index{.run_id = "run", .scene = testing::small_scene()};
  for (const std::vector<math::Vec3>& way : ways) {
    Entry entry{.name = {.run = "run", .draw = index.entries.size()}, .end_s = 1};
    for (std::uint32_t body = 0; body < 3; ++body) {
      const bool is_here = 2 * body + 1 < way.size();
      entry.tracks.push_back(
          {.first = static_cast<std::uint32_t>(entry.pieces.size()), .count = is_here ? 2U : 0U});
      if (!is_here) continue;
      entry.pieces.push_back({.start_s = 0,
                              .position_m = way[2 * body],
                              .velocity_mps = way[2 * body + 1] - way[2 * body]});
      entry.pieces.push_back({.start_s = 1, .position_m = way[2 * body + 1]});
    }
    measure_reach(entry);
    index.entries.push_back(std::move(entry));
  }
  return index;
}

Resemblance between(const Index& index) {
  return Sketches(entries_of(index), index.scene).between(0, 1);
}

TEST(Resemblance, IsWhatTheFormulaSays) {
  // A ball moves 1 m to the right in one animation and stays in the other. The distance is measured
  // at 64 moments from 0 to 1 s and once at rest. The mean distance is 33/65 m. The other two
  // bodies don't differ.
  const Resemblance of_one = between(two_ways({{{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}}));
  EXPECT_NEAR(of_one.greatest_m, 1, 1e-6);
  EXPECT_NEAR(of_one.mean_m, 33.0 / 65.0 / 3, 1e-2);
  EXPECT_EQ(of_one.order, 0);
  // Exchanging twins changes nothing visible; exchanging other bodies does.
  const math::Vec3 left{-1, 0, 0};
  const math::Vec3 right{1, 0, 0};
  const math::Vec3 up{0, 0, 1};
  EXPECT_EQ(between(two_ways({{left, up, right, right}, {right, right, left, up}})).value_m(), 0);
  Index apart = two_ways({{left, up, right, right}, {right, right, left, up}});
  apart.scene.features[1].twin_of = 1;
  EXPECT_GT(between(apart).value_m(), 1);
}

TEST(Resemblance, OfContactsCountsTheOrderOfTheFirst) {
  const math::Vec3 here{0, 0, 0};
  Index index = two_ways({{here, here, here, here}, {here, {0.1, 0, 0}, here, here}});
  index.scene.features[1].twin_of = 1;
  const auto contacts = [&](std::size_t entry,
                            std::vector<std::pair<std::uint32_t, std::uint32_t>> met) {
    index.entries[entry].contacts.clear();
    for (const auto& [body, partner] : met) {
      const double time_s = 0.01 * static_cast<double>(index.entries[entry].contacts.size());
      index.entries[entry].contacts.push_back({.time_s = time_s, .body = body, .partner = partner});
    }
  };
  const double same = between(index).value_m();
  contacts(0, {{0, 3}, {0, 4}, {1, 3}, {1, 4}});
  contacts(1, {{0, 3}, {0, 4}, {1, 3}, {1, 4}});
  EXPECT_EQ(between(index).order, 0);
  // Only the first hit of each pair of bodies counts.
  contacts(1, {{0, 3}, {0, 3}, {0, 4}, {1, 3}, {0, 3}, {1, 4}});
  EXPECT_EQ(between(index).order, 0);
  contacts(1, {{1, 4}, {0, 3}, {0, 4}, {1, 3}});
  EXPECT_EQ(between(index).order, 0.25);
  EXPECT_NEAR(between(index).value_m(), 1.25 * same, 1e-9);
  contacts(1, {{1, 4}, {1, 3}, {0, 4}, {0, 3}});
  EXPECT_EQ(between(index).order, 0.75);
  contacts(1, {});
  EXPECT_EQ(between(index).order, 1);
}

TEST(Resemblance, OfPlacesThatNoSceneHasIsFinite) {
  // A hostile archive may contain positions whose squares overflow a float. Valid places end at
  // 1e18 m.
  const math::Vec3 far = math::Vec3::Constant(1e27);
  const math::Vec3 here{0, 0, 0};
  const Index index = two_ways({{here, far, far, here}, {far, here, here, -far}});
  const Sketches sketches(entries_of(index), index.scene);
  for (const float value : sketches.matrix(2))
    EXPECT_TRUE(std::isfinite(value));
  EXPECT_GT(sketches.between(0, 1).value_m(), 1e18);
}

TEST(Resemblance, OfBodiesThatNeverEnterIsFinite) {
  const math::Vec3 here{0, 0, 0};
  const Resemblance one = between(two_ways({{here, here, here, here}, {here, here}}));
  EXPECT_TRUE(std::isfinite(one.value_m()));
  EXPECT_GT(one.value_m(), 0);
  EXPECT_EQ(between(two_ways({{}, {}})).value_m(), 0);
}

}  // namespace
}  // namespace sleight::browse
