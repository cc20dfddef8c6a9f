// A run makes checkpoints at the right times, and its workers don't wait for them.
#include "service/coordinator/checkpoints.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <new>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "service/coordinator/derive.h"

namespace sleight::coordinator {
namespace {

/// A clock that threads may read while the test sets it.
class SetClock final : public base::Clock {
 public:
  double now_s() const override { return now_s_; }
  void advance(double by_s) { now_s_ = now_s_ + by_s; }

 private:
  std::atomic<double> now_s_ = 1000;
};

class CheckpointsTest : public ::testing::Test {
 protected:
  /// Waits until the condition holds; fails after 20 s.
  static void await(const std::function<bool()>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!holds()) {
      ASSERT_LT(std::chrono::steady_clock::now(), end);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  SetClock clock_;
};

TEST_F(CheckpointsTest, ComeWithTheFirstSolutionAndThenEverySoOften) {
  // Goal: a run makes a checkpoint at its first solution, and then a checkpoint of its newest cut
  // every minute. Method: make one offer per second for five minutes. From the tenth second on,
  // there is a solution.
  std::vector<std::uint64_t> cuts;
  Checkpoints checkpoints(
      [&](const request::Cut& reached, const std::atomic<bool>&) {
        cuts.push_back(reached.scans);
        return Checkpoints::Made{.archive = true};
      },
      clock_, 60);
  for (std::uint64_t second = 1; second <= 300; ++second) {
    clock_.advance(1);
    checkpoints.offer({.reached = {.scans = second}, .has_solution = second >= 10, .workers = 2});
    if (second >= 10 && (second - 10) % 60 == 0)
      await([&] { return checkpoints.made() == 1 + (second - 10) / 60; });
  }
  checkpoints.stop();
  EXPECT_EQ(cuts, (std::vector<std::uint64_t>{10, 70, 130, 190, 250}));
}

TEST_F(CheckpointsTest, NothingIsMadeOfNothing) {
  // Goal: no checkpoint is made if there are no results, in the first half second, after stop(), or
  // if checkpoints are turned off.
  std::atomic<int> made = 0;
  const auto derive = [&](const request::Cut&, const std::atomic<bool>&) {
    ++made;
    return Checkpoints::Made{.archive = true};
  };
  {
    Checkpoints none(derive, clock_, 0);
    clock_.advance(100);
    none.offer({.reached = {.scans = 5}, .has_solution = true, .workers = 2});
  }
  Checkpoints checkpoints(derive, clock_, 60);
  checkpoints.offer({.reached = {.scans = 5}, .has_solution = true, .workers = 2});
  clock_.advance(100);
  checkpoints.offer({.has_solution = true});
  checkpoints.stop();
  checkpoints.offer({.reached = {.scans = 5}, .has_solution = true, .workers = 2});
  EXPECT_EQ(made, 0);
}

TEST_F(CheckpointsTest, FindsAreSeenAtOnce) {
  // Goal: an archive is derived as soon as a search has all its finds, even if the run ends during
  // the derivation. Method: make an offer at time 0, and call stop() during the derivation.
  std::atomic<int> begun = 0;
  std::atomic<bool> stops = false;
  Checkpoints checkpoints(
      [&](const request::Cut&, const std::atomic<bool>& stop) {
        ++begun;
        await([&] { return stops.load(); });
        for (int look = 0; look < 10'000 && !stop; ++look)
          std::this_thread::yield();
        EXPECT_FALSE(stop);
        return Checkpoints::Made{.archive = true};
      },
      clock_, 60);
  checkpoints.offer({.reached = {.found = 5}, .has_solution = true, .has_finds = true});
  await([&] { return begun == 1; });
  std::thread ends([&] {
    stops = true;
    checkpoints.stop();
  });
  ends.join();
  EXPECT_EQ(checkpoints.made(), 1U);
  EXPECT_EQ(begun, 1);
}

TEST_F(CheckpointsTest, NobodyWaitsAndOneIsMadeAtATime) {
  // Goal: during a derivation, offers return at once and don't start a second derivation. stop()
  // cancels the derivation. Method: make offers during a derivation that runs until it is
  // cancelled.
  std::atomic<int> begun = 0;
  std::atomic<bool> was_told = false;
  Checkpoints checkpoints(
      [&](const request::Cut&, const std::atomic<bool>& stop) -> Checkpoints::Made {
        ++begun;
        while (!stop)
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        was_told = true;
        throw DeriveStopped();
      },
      clock_, 60);
  clock_.advance(1);
  checkpoints.offer({.reached = {.scans = 1}, .has_solution = true, .workers = 2});
  await([&] { return begun == 1; });
  for (std::uint64_t scans = 2; scans < 100; ++scans) {
    clock_.advance(100);
    checkpoints.offer({.reached = {.scans = scans}, .has_solution = true, .workers = 2});
  }
  EXPECT_FALSE(was_told);
  checkpoints.stop();
  EXPECT_TRUE(was_told);
  EXPECT_EQ(begun, 1);
  EXPECT_EQ(checkpoints.made(), 0U);
}

TEST_F(CheckpointsTest, CostlyOnesAreRare) {
  // Goal: deriving archives takes at most 1% of the workers' time. The simulation of new motions
  // doesn't count. Method: let each checkpoint compute for 0.2 s. Motions take 0 s or 0.15 s of
  // this. With two workers, the next checkpoint must wait for 50 times the rest of the 0.2 s: at
  // least 10 s or 2.5 s.
  for (const double motions_s : {0.0, 0.15}) {
    std::atomic<double> cost_s = 0;
    Checkpoints checkpoints(
        [&](const request::Cut&, const std::atomic<bool>&) {
          const double begin_s = base::thread_processor_s();
          double now_s = begin_s;
          while (now_s < begin_s + 0.2)
            now_s = base::thread_processor_s();
          cost_s = now_s - begin_s - motions_s;
          return Checkpoints::Made{.archive = true, .motions_s = motions_s};
        },
        clock_, 1);
    const auto offer = [&](double after_s) {
      clock_.advance(after_s);
      checkpoints.offer({.reached = {.scans = 1}, .has_solution = true, .workers = 2});
    };
    offer(1);
    await([&] { return checkpoints.made() == 1; });
    offer(2);
    offer(0.9 * 50 * cost_s - 2);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    offer(0);
    EXPECT_EQ(checkpoints.made(), 1U);
    offer(0.2 * 50 * cost_s);
    await([&] { return checkpoints.made() == 2; });
  }
}

TEST_F(CheckpointsTest, OneThatFailsIsTriedAgain) {
  // Goal: checkpoints continue even if one fails or has no draws. A run tries each second to make
  // its first archive, and makes its second archive a minute after the first. Method: let two tries
  // fail in different ways. The third has no draws. Later tries succeed.
  std::atomic<int> tries = 0;
  Checkpoints checkpoints(
      [&](const request::Cut&, const std::atomic<bool>&) {
        const int nth = ++tries;
        if (nth == 1) throw base::Error("disk full");
        if (nth == 2) throw std::bad_alloc();
        return Checkpoints::Made{.archive = nth > 3};
      },
      clock_, 60);
  const auto offer = [&](double after_s) {
    clock_.advance(after_s);
    checkpoints.offer({.reached = {.scans = 1}, .has_solution = true});
  };
  offer(1);
  await([&] { return tries == 1; });
  for (int nth = 2; nth <= 4; ++nth) {
    // If a new attempt begins, the previous attempt has ended.
    await([&] {
      offer(1.5);
      return tries >= nth;
    });
  }
  await([&] { return checkpoints.made() == 1; });
  offer(61);
  await([&] { return checkpoints.made() == 2; });
}

TEST_F(CheckpointsTest, WhatGoesOnHasAnArchive) {
  // Goal: a resumed run makes a checkpoint at once only if it has no archive.
  for (const bool has_archive : {true, false}) {
    std::atomic<int> made = 0;
    Checkpoints checkpoints(
        [&](const request::Cut&, const std::atomic<bool>&) {
          ++made;
          return Checkpoints::Made{.archive = true};
        },
        clock_, 60, has_archive);
    clock_.advance(5);
    checkpoints.offer({.reached = {.scans = 1}, .has_solution = true});
    if (!has_archive) await([&] { return checkpoints.made() == 1; });
    checkpoints.stop();
    EXPECT_EQ(made, has_archive ? 0 : 1);
  }
}

}  // namespace
}  // namespace sleight::coordinator
