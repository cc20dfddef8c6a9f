#include "worker/run/sample_cache.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "worker/run/chain_worker.h"
#include "worker/worlds/ball_2d/ball_2d.h"

namespace sleight::run {
namespace {

constexpr std::uint64_t k_seed = 376730;
constexpr std::size_t k_plenty = 1'000'000;

plan::ReplicaKey key(std::uint32_t chain, std::uint32_t replica = 0) {
  return {base::ChainId{chain}, base::ReplicaId{replica}};
}

/// Bytes that a cache counts for a sample in addition to the sample's own bytes.
template <class Sample>
std::size_t bytes_besides() {
  SampleCache<Sample> cache(k_plenty);
  cache.put(key(0), 0, Sample{}, 0);
  return cache.use().bytes;
}

/// Reference cache: a plain list of held samples, oldest first.
class PlainCache {
 public:
  using Sample = std::shared_ptr<int>;
  explicit PlainCache(std::size_t bytes_max) { use_.bytes_max = bytes_max; }
  bool holds(const plan::ReplicaKey& replica, std::uint64_t scan) const {
    const auto found = std::ranges::find(held_, replica, &Entry::replica);
    return found != held_.end() && found->scan == scan;
  }
  std::weak_ptr<int> take(const plan::ReplicaKey& replica, std::uint64_t scan) {
    const auto found = std::ranges::find(held_, replica, &Entry::replica);
    if (found == held_.end() || found->scan != scan) {
      ++use_.misses;
      return {};
    }
    ++use_.hits;
    const std::weak_ptr<int> sample = found->sample;
    held_.erase(found);
    return sample;
  }
  void put(const plan::ReplicaKey& replica, std::uint64_t scan, std::weak_ptr<int> sample,
           std::size_t bytes) {
    std::erase_if(held_, [&](const Entry& entry) { return entry.replica == replica; });
    const std::size_t whole = bytes + bytes_besides<Sample>();
    if (whole > use_.bytes_max) return;
    while (this->bytes() + whole > use_.bytes_max) {
      held_.erase(held_.begin());
      ++use_.evictions;
    }
    held_.push_back({replica, scan, std::move(sample), whole});
  }
  plan::CacheUse use() const {
    plan::CacheUse now = use_;
    now.bytes = bytes();
    return now;
  }
  std::size_t count() const { return held_.size(); }

 private:
  struct Entry {
    plan::ReplicaKey replica;
    std::uint64_t scan = 0;
    std::weak_ptr<int> sample;
    std::size_t bytes = 0;
  };
  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const Entry& entry : held_)
      sum += entry.bytes;
    return sum;
  }
  std::vector<Entry> held_;
  plan::CacheUse use_;
};

constexpr std::uint64_t k_steps = 20'000;

/// Puts and takes samples of random sizes in random order. Compares the cache with the plain list:
/// results, reported use and number of live samples. Returns the first step at which they differ,
/// or k_steps if they never differ. Sets `use` to the plain list's use.
template <class Cache>
std::uint64_t first_difference(plan::CacheUse& use) {
  const std::size_t besides = bytes_besides<PlainCache::Sample>();
  const std::size_t bytes_max = 5 * (besides + 100);
  Cache cache(bytes_max);
  PlainCache plain(bytes_max);
  std::vector<std::weak_ptr<int>> all;
  random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, 0);
  const auto below = [&](std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream);
  };
  for (std::uint64_t step = 0; step < k_steps; ++step) {
    const plan::ReplicaKey replica =
        key(static_cast<std::uint32_t>(below(3)), static_cast<std::uint32_t>(below(3)));
    const std::uint64_t scan = below(2);
    if (cache.holds(replica, scan) != plain.holds(replica, scan)) return step;
    if (below(2) == 0) {
      auto sample = std::make_shared<int>(static_cast<int>(step));
      all.emplace_back(sample);
      // Some samples need almost all of the cache's room.
      const std::size_t bytes = below(20) == 0 ? bytes_max - besides - 2 + below(4) : below(200);
      plain.put(replica, scan, sample, bytes);
      cache.put(replica, scan, std::move(sample), bytes);
    } else {
      const std::shared_ptr<int> expected = plain.take(replica, scan).lock();
      const auto sample = cache.take(replica, scan);
      if (sample.has_value() != (expected != nullptr)) return step;
      if (sample && *sample != expected) return step;
    }
    std::erase_if(all, [](const std::weak_ptr<int>& sample) { return sample.expired(); });
    use = plain.use();
    if (all.size() != plain.count()) return step;
    if (cache.use() != use || cache.use().bytes > bytes_max) return step;
  }
  return k_steps;
}

using RightCache = SampleCache<PlainCache::Sample>;

TEST(SampleCache, IsAPlainListWithinItsBytes) {
  // Goal: the cache never exceeds its limit in bytes, evicts the least recently put sample first,
  // and counts hits, misses and evictions correctly. Method: put and take random samples, and
  // compare the cache with a plain list.
  plan::CacheUse use;
  EXPECT_EQ(first_difference<RightCache>(use), k_steps) << "seed " << k_seed;
  EXPECT_GT(use.hits, 1000U);
  EXPECT_GT(use.misses, 1000U);
  EXPECT_GT(use.evictions, 1000U);
}

/// A faulty cache with room for one byte too many.
struct LooseCache : RightCache {
  explicit LooseCache(std::size_t bytes_max) : RightCache(bytes_max + 1), right_max(bytes_max) {}
  plan::CacheUse use() const {
    plan::CacheUse said = RightCache::use();
    said.bytes_max = right_max;
    return said;
  }
  std::size_t right_max;
};

/// A faulty cache that underestimates the size of samples.
struct LightCache : RightCache {
  using RightCache::RightCache;
  void put(const plan::ReplicaKey& replica, std::uint64_t scan, PlainCache::Sample sample,
           std::size_t bytes) {
    RightCache::put(replica, scan, std::move(sample), bytes / 2);
  }
};

/// A faulty cache that keeps a copy of a sample after take().
struct FondCache : RightCache {
  using RightCache::RightCache;
  std::optional<PlainCache::Sample> take(const plan::ReplicaKey& replica, std::uint64_t scan) {
    std::optional<PlainCache::Sample> sample = RightCache::take(replica, scan);
    if (sample) last = *sample;
    return sample;
  }
  PlainCache::Sample last;  ///< still held
};

TEST(SampleCache, PropertyFindsWrongCaches) {
  // Goal: first_difference() detects faulty caches. Method: use three caches. Each cache has one
  // small mistake.
  plan::CacheUse use;
  EXPECT_LT(first_difference<LooseCache>(use), k_steps);
  EXPECT_LT(first_difference<LightCache>(use), k_steps);
  EXPECT_LT(first_difference<FondCache>(use), k_steps);
}

TEST(SampleCache, IsSharedByThreads) {
  // Goal: several threads can share a cache. Each sample is taken at most once, and the cache
  // counts each take once. Method: put and take samples of twelve replicas in four threads.
  SampleCache<std::unique_ptr<int>> cache(8 * (100 + bytes_besides<std::unique_ptr<int>>()));
  std::atomic<int> taken = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 5000; ++i) {
        const auto replica = key(static_cast<std::uint32_t>((i + t) % 12));
        cache.put(replica, 1, std::make_unique<int>(i), 100);
        if (const auto sample = cache.take(replica, 1)) taken += *sample ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_GT(taken, 0);
  const plan::CacheUse use = cache.use();
  EXPECT_EQ(use.hits, static_cast<std::uint64_t>(taken));
  EXPECT_EQ(use.hits + use.misses, 20'000U);
  EXPECT_LE(use.bytes, use.bytes_max);
}

TEST(ChainWorker, StartsAtTheScanThatItsUnitSays) {
  // Goal: a unit starts from a new draw exactly if its flag `starts` is set. The first scan's
  // number doesn't matter. The draw and its lineage belong to the unit's first scan. Without the
  // flag, the unit continues from the given state.
  const worlds::ball_2d::Ball2d ball({});
  const ChainWorker<worlds::ball_2d::Ball2d> worker(ball, {});
  const plan::Unit unit{.replica = key(2, 5),
                        .seed = 11,
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
  // Goal: at inverse temperature 1, a worker stores all satisfying states. From the first draw on,
  // it also stores one state per `thin` scans. At other inverse temperatures, the worker stores one
  // state per `hot_thin` scans. Method: run 60 scans with the first draw at scan 25.
  const worlds::ball_2d::Ball2d ball({});
  const ChainWorker<worlds::ball_2d::Ball2d> worker(ball,
                                                    {.thin = 4, .first_draw = 25, .hot_thin = 6});
  for (const double beta : {0.5, 1.0}) {
    const plan::Unit unit{.replica = key(0),
                          .seed = 11,
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
