// Samples held between units: what is taken, what is given up, and that results don't show it.
#include "worker/run/sample_cache.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>

#include "common/random/discrete_distributions.h"
#include "worker/run/chain_worker.h"
#include "worker/worlds/ball_2d/ball_2d.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::run {
namespace {

constexpr std::uint64_t k_seed = 376730;

plan::ReplicaKey key(std::uint32_t chain, std::uint32_t replica = 0) {
  return {base::ChainId{chain}, base::ReplicaId{replica}};
}

TEST(SampleCache, GivesWhatWasPutOnce) {
  // Goal: a sample comes back for its replica and scan alone, and is gone then. Method: by hand.
  SampleCache<int> cache(4);
  EXPECT_EQ(cache.take(key(0), 1), std::nullopt);
  cache.put(key(0), 10, 7);
  EXPECT_EQ(cache.take(key(0), 9), std::nullopt);
  EXPECT_EQ(cache.take(key(1), 10), std::nullopt);
  EXPECT_EQ(cache.take(key(0, 1), 10), std::nullopt);
  EXPECT_EQ(cache.take(key(0), 10), 7);
  EXPECT_EQ(cache.take(key(0), 10), std::nullopt);
  cache.put(key(0), 11, 8);
  cache.put(key(0), 12, 9);
  EXPECT_EQ(cache.take(key(0), 11), std::nullopt);
  EXPECT_EQ(cache.take(key(0), 12), 9);
}

TEST(SampleCache, GivesUpWhatWasPutLongestAgo) {
  // Goal: bounded, least recently put first out. Method: against a plain list, random puts and
  // takes; no more samples live than the bound.
  constexpr std::size_t k_bound = 5;
  struct Entry {
    plan::ReplicaKey replica;
    std::uint64_t scan = 0;
    std::weak_ptr<int> sample;
  };
  SampleCache<std::shared_ptr<int>> cache(k_bound);
  std::vector<Entry> plain;  // oldest first
  std::vector<std::weak_ptr<int>> all;
  std::size_t hits = 0;
  std::size_t misses = 0;
  random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, 0);
  for (int step = 0; step < 20'000; ++step) {
    const auto below = [&](std::uint64_t count) {
      return random::UniformInteger{.count = count}.draw(stream);
    };
    const plan::ReplicaKey replica =
        key(static_cast<std::uint32_t>(below(3)), static_cast<std::uint32_t>(below(3)));
    const std::uint64_t scan = below(2);
    const auto found = std::ranges::find(plain, replica, &Entry::replica);
    if (below(2) == 0) {
      auto sample = std::make_shared<int>(step);
      all.emplace_back(sample);
      if (found != plain.end()) plain.erase(found);
      if (plain.size() == k_bound) plain.erase(plain.begin());
      plain.push_back({replica, scan, sample});
      cache.put(replica, scan, std::move(sample));
    } else {
      const auto sample = cache.take(replica, scan);
      const bool expected = found != plain.end() && found->scan == scan;
      ASSERT_EQ(sample.has_value(), expected) << "seed " << k_seed << ", step " << step;
      (expected ? hits : misses) += 1;
      if (!expected) continue;
      ASSERT_EQ(*sample, found->sample.lock());
      plain.erase(found);
    }
    std::erase_if(all, [](const std::weak_ptr<int>& sample) { return sample.expired(); });
    ASSERT_EQ(all.size(), plain.size());
  }
  EXPECT_GT(hits, 1000U);
  EXPECT_GT(misses, 1000U);
}

TEST(SampleCache, IsSharedByThreads) {
  // Goal: no sample goes to two. Method: four threads that put and take the same keys.
  SampleCache<std::unique_ptr<int>> cache(8);
  std::atomic<int> taken = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 5000; ++i) {
        const auto replica = key(static_cast<std::uint32_t>((i + t) % 12));
        cache.put(replica, 1, std::make_unique<int>(i));
        if (const auto sample = cache.take(replica, 1)) taken += *sample ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_GT(taken, 0);
  EXPECT_LE(taken, 20'000);
}

plan::Unit random_unit(const plan::ReplicaKey& replica, std::uint64_t first,
                       random::Stream& stream) {
  const auto below = [&](std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream);
  };
  plan::Unit unit{.replica = replica,
                  .first_scan = base::ScanIndex{first},
                  .scans = static_cast<std::uint32_t>(1 + below(5)),
                  .starts = first == 0,
                  .lineage = 0};
  const double betas[] = {0, 0.1, 0.5, 1};
  unit.inverse_temperatures.clear();
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth)
    unit.inverse_temperatures.push_back(betas[below(4)]);
  if (below(2) == 0) {
    unit.inverse_temperatures = {1};
    unit.excursion = {0.5, 0.1, 0};
  }
  return unit;
}

/// Five replicas by turns, in random units at random temperatures: with a worker that ran all units
/// before, and with one that is new for each.
template <class Make>
void expect_cache_does_not_show(const Make& make_world, const ChainWorkerOptions& options) {
  const ChainWorker held(make_world(), options);
  random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, 1);
  struct Chain {
    std::uint64_t next = 0;
    std::uint64_t lineage = 0;
    base::Bytes state;
  };
  std::vector<Chain> chains(5);
  for (int turn = 0; turn < 150; ++turn) {
    const auto id =
        static_cast<std::uint32_t>(random::UniformInteger{.count = chains.size()}.draw(stream));
    Chain& chain = chains[id];
    plan::Unit unit = random_unit(key(id / 2, id % 2), chain.next, stream);
    unit.lineage = chain.lineage;
    const plan::UnitResult hit = held.run(unit, chain.state);
    const plan::UnitResult miss = ChainWorker(make_world(), options).run(unit, chain.state);
    ASSERT_EQ(hit.scans, miss.scans) << "seed " << k_seed << ", turn " << turn;
    ASSERT_EQ(hit.state_after, miss.state_after);
    // Now and then a unit is computed again, or its result is lost.
    if (turn % 7 == 3) {
      ASSERT_EQ(held.run(unit, chain.state).scans, miss.scans);
    }
    if (turn % 11 == 5) continue;
    chain = {chain.next + unit.scans, hit.scans.back().lineage, hit.state_after};
  }
}

TEST(ChainWorkerCache, DoesNotShowInResults) {
  // Goal: results are equal with and without what a worker holds. Method: both worlds.
  expect_cache_does_not_show([] { return worlds::ball_2d::Ball2d({}); },
                             {.seed = 3, .iterations_per_scan = 2});
  worlds::spelling::Parameters spelling;
  spelling.pattern = worlds::spelling::pattern_of_rows("##").value();
  expect_cache_does_not_show([&] { return worlds::spelling::Spelling(spelling); },
                             {.seed = 4, .iterations_per_scan = 1, .thin = 3, .first_draw = 4});
}

TEST(ChainWorker, StartsAtTheScanThatItsUnitSays) {
  // Goal: `starts` alone says that there is no state before, at any scan: the draw and its lineage
  // are that scan's; and a first scan 0 that doesn't start goes on. Method: units at scan 20.
  const worlds::ball_2d::Ball2d ball({});
  const ChainWorker<worlds::ball_2d::Ball2d> worker(ball, {.seed = 11});
  const plan::Unit unit{.replica = key(2, 5),
                        .first_scan = base::ScanIndex{20},
                        .scans = 3,
                        .starts = true,
                        .lineage = 77,
                        .inverse_temperatures = {0.25}};
  const plan::UnitResult result = worker.run(unit, {});
  const auto start = sampling::draw_afresh(
      ball, {.seed = 11, .chain = base::ChainId{2}, .replica = base::ReplicaId{5}}, 20);
  EXPECT_EQ(result.scans[0].log_prior, start.log_prior);
  EXPECT_EQ(result.scans[0].outcome, ball.outcome_values(start.outcome));
  EXPECT_EQ(result.scans[0].proposed[0], 0U);
  EXPECT_EQ(result.scans[1].proposed[0], 1U);
  for (const plan::ScanRecord& scan : result.scans) {
    EXPECT_EQ(scan.lineage, plan::lineage_from(base::ReplicaId{5}, 20));
    EXPECT_EQ(scan.inverse_temperature, 0.25);
  }
  plan::Unit goes_on = unit;
  goes_on.starts = false;
  const plan::UnitResult after = worker.run(goes_on, ball.encode(start.state));
  EXPECT_EQ(after.scans[0].proposed[0], 1U);
  EXPECT_EQ(after.scans[0].lineage, 77U);
}

TEST(ChainWorker, KeepsStatesFromTheFirstDrawOn) {
  // Goal: thin counts from the first draw; before it only satisfied states at inverse temperature 1
  // are kept, and hot ones as hot_thin says. Method: 60 scans, the first draw at 25.
  const worlds::ball_2d::Ball2d ball({});
  const ChainWorker<worlds::ball_2d::Ball2d> worker(
      ball, {.seed = 11, .thin = 4, .first_draw = 25, .hot_thin = 6});
  for (const double beta : {0.5, 1.0}) {
    const plan::Unit unit{.replica = key(0),
                          .first_scan = base::ScanIndex{0},
                          .scans = 60,
                          .starts = true,
                          .lineage = 0,
                          .inverse_temperatures = {beta}};
    const plan::UnitResult result = worker.run(unit, {});
    for (std::uint64_t scan = 0; scan < 60; ++scan) {
      const plan::ScanRecord& record = result.scans[scan];
      const bool thin = scan >= 25 && (scan - 25) % 4 == 0;
      const bool kept = beta == 1 ? thin || record.satisfied : scan % 6 == 0;
      EXPECT_EQ(!record.state.empty(), kept) << scan;
    }
  }
}

}  // namespace
}  // namespace sleight::run
