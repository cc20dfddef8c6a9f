// Goal: groups follow their stated methods, and don't depend on the order of animations. Method:
// compare medoids with all choices and exchanges. Compare hierarchies with the plain algorithm.
// Group the same animations in different orders.
#include "clients/browse/groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include "clients/browse/agreement.h"
#include "tests/support/property.h"
#include "tests/unit/clients/browse/random_index.h"

namespace sleight::browse::groups_test {

using testing::below;
using testing::entries_of;
using testing::random_index;

constexpr std::uint64_t k_seed = 28;

/// Returns distances between random points in a plane. The points form one to four clumps.
std::vector<float> matrix_of(std::size_t size, random::Stream& stream) {
  std::vector<math::Vec3> points;
  const std::size_t clumps = 1 + below(stream, 4);
  for (std::size_t i = 0; i < size; ++i) {
    const auto clump = static_cast<double>(below(stream, clumps));
    points.emplace_back(clump + 0.3 * stream.uniform(), clump * clump + 0.3 * stream.uniform(), 0);
  }
  std::vector<float> matrix(size * size);
  for (std::size_t a = 0; a < size; ++a) {
    for (std::size_t b = 0; b < size; ++b)
      matrix[a * size + b] = static_cast<float>((points[a] - points[b]).norm());
  }
  return matrix;
}

double cost_of(const std::vector<float>& matrix, std::size_t size,
               const std::vector<std::size_t>& medoids) {
  double sum = 0;
  for (std::size_t i = 0; i < size; ++i) {
    float nearest = std::numeric_limits<float>::infinity();
    for (const std::size_t medoid : medoids)
      nearest = std::min(nearest, matrix[i * size + medoid]);
    sum += nearest;
  }
  return sum;
}

TEST(Groups, NoExchangeOfOneMedoidHelps) {
  int best = 0;
  int cases = 0;
  for (const std::uint64_t n : property::cases(200)) {
    random::Stream stream = testing::stream_of(k_seed, n);
    const std::size_t size = 2 + below(stream, 9);
    const std::size_t k = 1 + below(stream, std::min<std::size_t>(size, 4));
    const std::vector<float> matrix = matrix_of(size, stream);
    const std::vector<std::size_t> medoids = medoids_of(matrix, size, k);
    ASSERT_EQ(medoids.size(), k);
    EXPECT_TRUE(std::ranges::is_sorted(medoids));
    const double cost = cost_of(matrix, size, medoids);
    for (std::size_t i = 0; i < k; ++i) {
      for (std::size_t other = 0; other < size; ++other) {
        std::vector<std::size_t> exchanged = medoids;
        exchanged[i] = other;
        EXPECT_GE(cost_of(matrix, size, exchanged), cost - 1e-6);
      }
    }
    std::vector<char> chosen(size, 0);
    std::fill_n(chosen.begin(), k, 1);
    double least = cost;
    do {
      std::vector<std::size_t> choice;
      for (std::size_t i = 0; i < size; ++i) {
        if (chosen[i] != 0) choice.push_back(i);
      }
      least = std::min(least, cost_of(matrix, size, choice));
    } while (std::ranges::prev_permutation(chosen).found);
    ++cases;
    if (cost <= least + 1e-6) ++best;
  }
  // Exchanges end in a local optimum. Usually it is the global optimum.
  if (property::all_cases()) {
    EXPECT_GE(best, cases * 9 / 10);
  }
}

bool is_same_division(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j)
      if ((a[i] == a[j]) != (b[i] == b[j])) return false;
  }
  return a.size() == b.size();
}

std::vector<std::size_t> plain_hierarchy(const std::vector<float>& matrix, std::size_t size,
                                         std::size_t k) {
  std::vector<std::vector<std::size_t>> groups(size);
  for (std::size_t i = 0; i < size; ++i)
    groups[i] = {i};
  while (groups.size() > k) {
    double least = std::numeric_limits<double>::infinity();
    std::pair<std::size_t, std::size_t> nearest;
    for (std::size_t a = 0; a < groups.size(); ++a) {
      for (std::size_t b = a + 1; b < groups.size(); ++b) {
        double sum = 0;
        for (const std::size_t i : groups[a]) {
          for (const std::size_t j : groups[b])
            sum += matrix[i * size + j];
        }
        const double mean = sum / static_cast<double>(groups[a].size() * groups[b].size());
        if (mean < least) {
          least = mean;
          nearest = {a, b};
        }
      }
    }
    auto& into = groups[nearest.first];
    into.insert(into.end(), groups[nearest.second].begin(), groups[nearest.second].end());
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(nearest.second));
  }
  std::vector<std::size_t> labels(size);
  for (std::size_t group = 0; group < groups.size(); ++group) {
    for (const std::size_t i : groups[group])
      labels[i] = group;
  }
  return labels;
}

TEST(Groups, HierarchyJoinsTheNearest) {
  for (const std::uint64_t n : property::cases(200)) {
    random::Stream stream = testing::stream_of(k_seed, 1000 + n);
    const std::size_t size = 1 + below(stream, 12);
    const std::size_t k = 1 + below(stream, size);
    const std::vector<float> matrix = matrix_of(size, stream);
    const std::vector<std::size_t> found = hierarchy_of(matrix, size, k);
    EXPECT_EQ(std::set<std::size_t>(found.begin(), found.end()).size(), k);
    EXPECT_TRUE(is_same_division(found, plain_hierarchy(matrix, size, k)));
    // If two members share a group of k groups, they still share a group when there are k - 1.
    if (k == 1) continue;
    const std::vector<std::size_t> wider = hierarchy_of(matrix, size, k - 1);
    std::map<std::size_t, std::size_t> into;
    for (std::size_t i = 0; i < size; ++i)
      EXPECT_EQ(into.try_emplace(found[i], wider[i]).first->second, wider[i]);
  }
}

std::map<std::uint64_t, std::set<std::uint64_t>> named(const Groups& groups,
                                                       const std::vector<const Entry*>& entries) {
  std::map<std::uint64_t, std::set<std::uint64_t>> all;
  for (const AlikeGroup& group : groups.groups) {
    std::set<std::uint64_t>& members = all[entries[group.representative]->name.draw];
    for (const std::size_t member : group.members)
      members.insert(entries[member]->name.draw);
  }
  return all;
}

TEST(Groups, AreTheSameInAnyOrder) {
  random::Stream stream = testing::stream_of(k_seed, 1);
  for (const std::size_t size : {1UL, 3UL, 40UL, 505UL}) {
    const Index index = random_index(size, stream);
    for (const Grouping by : {Grouping::medoids, Grouping::hierarchy}) {
      if (size > k_full_matrix_max && by == Grouping::hierarchy) continue;  // too slow
      std::vector<const Entry*> entries = entries_of(index);
      const Groups first = groups_of(entries, index.scene, {.groups = 7, .by = by});
      EXPECT_EQ(first.is_approximate, size > k_full_matrix_max);
      EXPECT_EQ(first.groups.size(), std::min<std::size_t>(size, 7));
      const auto expected = named(first, entries);
      std::size_t members = 0;
      for (const auto& [representative, group] : expected) {
        EXPECT_TRUE(group.contains(representative));
        members += group.size();
      }
      EXPECT_EQ(members, size);
      for (std::size_t i = size - 1; i > 0; --i)
        std::swap(entries[i], entries[below(stream, i + 1)]);
      const Groups again = groups_of(entries, index.scene, {.groups = 7, .by = by, .threads = 3});
      EXPECT_EQ(named(again, entries), expected);
    }
  }
}

TEST(Groups, OfClumpsAreTheClumps) {
  // There are four kinds of animations, 30 of each. Animations vary much less within a kind than
  // between kinds.
  random::Stream stream = testing::stream_of(k_seed, 2);
  const Index kinds = random_index(4, stream);
  Index index = kinds;
  index.entries.clear();
  std::vector<std::size_t> kind_of;
  for (std::uint64_t draw = 0; draw < 120; ++draw) {
    Entry entry = kinds.entries[draw % 4];
    entry.name.draw = draw;
    const math::Vec3 shift = testing::random_vector(stream, 0.002);
    for (Piece& piece : entry.pieces)
      piece.position_m += shift;
    index.entries.push_back(std::move(entry));
    kind_of.push_back(draw % 4);
  }
  const std::vector<const Entry*> entries = entries_of(index);
  for (const Grouping by : {Grouping::medoids, Grouping::hierarchy}) {
    const Groups groups = groups_of(entries, index.scene, {.groups = 4, .by = by});
    std::vector<std::size_t> label(entries.size());
    for (std::size_t group = 0; group < groups.groups.size(); ++group) {
      EXPECT_LT(groups.groups[group].greatest_m, 0.02);
      for (const std::size_t member : groups.groups[group].members)
        label[member] = group;
    }
    EXPECT_TRUE(is_same_division(label, kind_of));
  }
}

TEST(Agreement, NeighboursTellTwoSetsFromOne) {
  random::Stream stream = testing::stream_of(k_seed, 4);
  constexpr std::size_t k_size = 80;
  const auto test_of = [&](double apart) {
    std::vector<double> place;
    std::vector<std::uint8_t> set_of;
    for (std::size_t i = 0; i < k_size; ++i) {
      set_of.push_back(i % 2);
      place.push_back(stream.uniform() + (i % 2 == 0 ? 0 : apart));
    }
    std::vector<float> matrix(k_size * k_size);
    for (std::size_t i = 0; i < k_size; ++i) {
      for (std::size_t j = 0; j < k_size; ++j)
        matrix[i * k_size + j] = static_cast<float>(std::abs(place[i] - place[j]));
    }
    return neighbour_test(matrix, set_of);
  };
  const NeighbourTest far = test_of(5);
  EXPECT_EQ(far.share, 1);
  EXPECT_NEAR(far.p_value, 1.0 / (k_deals + 1), 1e-12);
  // If both sets have the same distribution, p-values are uniform or slightly larger.
  int small = 0;
  for (int i = 0; i < 100; ++i) {
    const NeighbourTest same = test_of(0);
    EXPECT_NEAR(same.expected, 0.5, 0.02);
    if (same.p_value < 0.1) ++small;
  }
  EXPECT_LE(small, 20);
}

TEST(AlikeSets, AreGroupedAgainAsTheFirstTime) {
  // Goal: the state that an AlikeSet stores between groupings doesn't change the groups. Method:
  // make different numbers of groups by both methods, for a small set (full matrix) and a large set
  // (sampled). Compare each grouping with a grouping from scratch. Compare distances with the
  // distances of Sketches.
  random::Stream stream = testing::stream_of(k_seed, 27);
  for (const std::size_t size : {60UL, 505UL}) {
    const Index index = random_index(size, stream);
    const std::vector<const Entry*> entries = entries_of(index);
    const AlikeSet set(entries, index.scene, 2);
    for (const std::size_t k : {7U, 3U, 7U, 1U, 12U}) {
      for (const Grouping by : {Grouping::medoids, Grouping::hierarchy}) {
        if (size > k_full_matrix_max && k != 3) continue;  // too slow
        const Groups again = set.groups(k, by);
        const Groups once = groups_of(entries, index.scene, {.groups = k, .by = by});
        ASSERT_EQ(again.groups.size(), once.groups.size());
        EXPECT_EQ(again.is_approximate, once.is_approximate);
        for (std::size_t i = 0; i < once.groups.size(); ++i) {
          EXPECT_EQ(again.groups[i].representative, once.groups[i].representative);
          EXPECT_EQ(again.groups[i].members, once.groups[i].members);
          EXPECT_EQ(again.groups[i].mean_m, once.groups[i].mean_m);
          EXPECT_EQ(again.groups[i].greatest_m, once.groups[i].greatest_m);
        }
      }
    }
    const Sketches sketches(entries, index.scene);
    for (std::size_t other = 0; other < 20; ++other)
      EXPECT_EQ(set.between(5, other).value_m(), sketches.between(5, other).value_m());
  }
}

}  // namespace sleight::browse::groups_test
