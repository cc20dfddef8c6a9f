#include "common/store/run_store.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <thread>

#include "common/base/error.h"
#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::store {
namespace {

using testing::expect_stored;
using testing::forged;
using testing::result_of;

class RunStoreOf : public testing::RunFolder {
 protected:
  void open(std::uint32_t chains = 2) {
    store_.reset();
    store_.emplace(folder(), testing::example_identity(chains));
  }

  std::optional<RunStore> store_;
};

TEST_F(RunStoreOf, NewRunIsEmpty) {
  // Goal: a new run has no scans and no progress, even after it is opened again.
  open();
  EXPECT_EQ(store_->epoch(), 1U);
  EXPECT_TRUE(store_->progress().empty());
  expect_stored(folder(), *store_, 0, 0);
  store_->flush();
  EXPECT_EQ(store_->committed(), 0U);
  open();
  EXPECT_EQ(store_->epoch(), 2U);
  EXPECT_TRUE(store_->progress().empty());
}

TEST_F(RunStoreOf, GivesBackWhatWasPut) {
  // Goal: after a flush, results can be read by any reader, and after the store is reopened.
  // Method: store two chains in units of several sizes. One chain has more scans than a batch of a
  // replay.
  open();
  std::uint64_t next = 0;
  for (const std::uint32_t scans : {1U, 2U, 100U, 4096U, 7U, 1000U}) {
    store_->put(result_of(1, next, scans));
    next += scans;
  }
  store_->put(result_of(0, 0, 5));
  store_->flush();
  EXPECT_EQ(store_->committed(), next + 5);
  for (int session = 0; session < 2; ++session) {
    expect_stored(folder(), *store_, 0, 5);
    expect_stored(folder(), *store_, 1, next);
    open();
  }
  EXPECT_EQ(store_->committed(), 0U);
}

TEST_F(RunStoreOf, ProgressIsInOrder) {
  // Goal: progress() sorts replicas by chain number, then by replica number. Method: put results
  // out of order. Use numbers that are far apart.
  open();
  for (const auto& [chain, replica] :
       {std::pair{70'000U, 1U}, {3U, 0U}, {0xffffffffU, 0U}, {3U, 0xffffffffU}, {70'000U, 0U}}) {
    plan::UnitResult result = result_of(chain, 0, 2);
    result.unit.replica.replica = base::ReplicaId{replica};
    store_->put(result);
  }
  store_->flush();
  std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
  for (const ReplicaProgress& progress : store_->progress()) {
    found.emplace_back(progress.replica.chain.value, progress.replica.replica.value);
    EXPECT_EQ(progress.next_scan, 2U);
  }
  EXPECT_THAT(found, ::testing::ElementsAre(std::pair{3U, 0U}, std::pair{3U, 0xffffffffU},
                                            std::pair{70'000U, 0U}, std::pair{70'000U, 1U},
                                            std::pair{0xffffffffU, 0U}));
}

TEST_F(RunStoreOf, AnyOrderOfDoubledAndOverlappingUnits) {
  // Goal: whatever the order of results, a scan's first result stays, and no replica has a gap
  // (invariants 2 and 4). Method: put random units that continue, repeat or overlap stored units.
  // If a scan is already stored, change its values. Flush and open new sessions at random.
  constexpr std::uint64_t k_seed = 4711;
  SCOPED_TRACE(fmt::format("seed {}", k_seed));
  random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, 0);
  const auto below = [&](std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream);
  };
  open(3);
  std::vector<std::uint64_t> next(3, 0);
  for (int i = 0; i < 400; ++i) {
    const auto chain = static_cast<std::uint32_t>(below(3));
    const std::uint64_t first = next[chain] - std::min(next[chain], below(20));
    const auto scans = static_cast<std::uint32_t>(1 + below(25));
    plan::UnitResult result = result_of(chain, first, scans);
    const plan::UnitResult changed = forged(result);
    for (std::uint64_t scan = first; scan < std::min(first + scans, next[chain]); ++scan)
      result.scans[scan - first] = changed.scans[scan - first];
    if (first + scans <= next[chain]) result.state_after = changed.state_after;
    next[chain] = std::max(next[chain], first + scans);
    store_->put(std::move(result));
    if (below(10) == 0) store_->flush();
    if (below(40) == 0) open(3);
  }
  open(3);
  for (std::uint32_t chain = 0; chain < 3; ++chain)
    expect_stored(folder(), *store_, chain, next[chain]);
}

TEST_F(RunStoreOf, TakesFromManyThreads) {
  // Goal: put(), flush() and committed() may be called from any thread.
  open(4);
  std::vector<std::thread> threads;
  for (std::uint32_t chain = 0; chain < 4; ++chain) {
    threads.emplace_back([this, chain] {
      for (std::uint64_t scan = 0; scan < 300; scan += 3) {
        store_->put(result_of(chain, scan, 3));
        if (scan % 60 == 0) store_->flush();
      }
      store_->flush();
      EXPECT_GE(store_->committed(), 300U);
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_EQ(store_->committed(), 1200U);
  for (std::uint32_t chain = 0; chain < 4; ++chain)
    expect_stored(folder(), *store_, chain, 300);
}

using RunStoreOfDeathTest = RunStoreOf;

TEST_F(RunStoreOfDeathTest, GapIsABug) {
  // Goal: if a result would leave a gap in a replica's scans, a CHECK fails (invariant 4).
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        RunStore store(folder(), testing::example_identity(1));
        store.put(result_of(0, 3, 2));
        store.flush();
      },
      "check failed: .*first_scan.*3 against 0");
}

}  // namespace
}  // namespace sleight::store
