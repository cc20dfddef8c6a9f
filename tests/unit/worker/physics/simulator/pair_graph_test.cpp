#include "worker/physics/simulator/pair_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "common/random/distributions.h"
#include "common/random/stream.h"
#include "tests/support/property.h"

namespace sleight::physics {
namespace {

TEST(PairGraph, HasWhatAMapHas) {
  // Goal: while lists grow, shrink or move into unused space, the graph keeps each edge and the
  // edge's prediction. A new edge has no prediction. Method: add, predict and remove random pairs,
  // and compare the graph with a map. Half of the graphs store details. Some bodies have almost all
  // others as neighbours.
  constexpr std::uint32_t k_bodies = 90;
  for (const std::uint64_t seed : property::cases(property::long_run() ? 400 : 20)) {
    random::Stream stream({.seed = 71, .purpose = random::Purpose::scene}, seed);
    const auto below = [&](std::uint32_t count) {
      return static_cast<std::uint32_t>(random::UniformInteger{.count = count}.draw(stream));
    };
    const bool has_details = seed % 2 == 0;
    PairGraph graph;
    graph.reset(k_bodies, {.list = 16, .average = 4, .details = has_details});
    // Predicted tick of each pair of bodies. If the prediction is void, the tick is k_never.
    std::map<std::pair<std::uint32_t, std::uint32_t>, Tick> expected;
    std::uint32_t searches = 0;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> search_of;
    for (int step = 0; step < 3000; ++step) {
      const BodyId a{step / 300 % 2 == 0 ? below(4) : below(k_bodies)};
      const BodyId b{below(k_bodies)};
      if (a == b) continue;
      const auto one = std::pair(a.value, b.value);
      const auto other = std::pair(b.value, a.value);
      if (!expected.contains(one)) {
        graph.add(a, b);
        expected[one] = expected[other] = k_never;
        ASSERT_EQ(*graph.find(a, b)->other_changes, k_void);
        if (has_details) {
          search_of[one] = search_of[other] = searches;
          graph.find(a, b)->detail->search = graph.find(b, a)->detail->search = searches++;
        }
      } else if (below(3) > 0) {
        const PairEdge edge = *graph.find(a, b);
        const Tick tick{static_cast<TickCount>(below(1'000'000))};
        edge.predict({.tick = tick, .feature = has_details ? 7U : 0U, .certain = true});
        *edge.other_changes = b.value;
        expected[one] = tick;
      } else {
        const std::uint32_t search = graph.remove(a, b);
        ASSERT_EQ(search, has_details ? search_of[one] : k_no_search);
        expected.erase(one);
        expected.erase(other);
      }
    }
    for (BodyId body{}; body < k_bodies; ++body) {
      const PairEdges edges = graph.edges_of(body);
      std::set<std::uint32_t> others;
      for (std::size_t i = 0; i < edges.count; ++i) {
        const PairEdge edge = edges[i];
        others.insert(edge.other);
        ASSERT_EQ(graph.others_of(body)[i], edge.other);
        const auto found = expected.find({body.value, edge.other.value});
        ASSERT_NE(found, expected.end());
        if (found->second == k_never) {
          ASSERT_EQ(*edge.other_changes, k_void);
          continue;
        }
        ASSERT_EQ(*edge.other_changes, edge.other.value);
        ASSERT_EQ(edge.prediction().tick, found->second);
        ASSERT_TRUE(edge.prediction().certain);
        ASSERT_EQ(edge.prediction().feature, has_details ? 7U : 0U);
      }
      ASSERT_EQ(others.size(), edges.count);
    }
    std::size_t all = 0;
    for (BodyId body{}; body < k_bodies; ++body)
      all += graph.others_of(body).size();
    ASSERT_EQ(all, expected.size());
    ASSERT_FALSE(graph.find({0}, {0}).has_value());
  }
}

}  // namespace
}  // namespace sleight::physics
