// Archives of a run so far: when they are made, and that nobody waits for them.
#include "service/coordinator/checkpoints.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
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
  /// Waits for what the thread does; fails after 20 s.
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
  // Goal: one as soon as there is a solution, then one each minute, of what is reached by then.
  // Method: a clock set by hand, an offer each second for five minutes, a solution after ten.
  std::vector<std::uint64_t> cuts;
  Checkpoints checkpoints(
      [&](const Reached& reached, const std::atomic<bool>&) { cuts.push_back(reached.scans); },
      clock_, 60);
  for (std::uint64_t second = 1; second <= 300; ++second) {
    clock_.advance(1);
    checkpoints.offer({.scans = second}, second >= 10);
    if (second >= 10 && (second - 10) % 60 == 0)
      await([&] { return checkpoints.made() == 1 + (second - 10) / 60; });
  }
  checkpoints.stop();
  EXPECT_EQ(cuts, (std::vector<std::uint64_t>{10, 70, 130, 190, 250}));
}

TEST_F(CheckpointsTest, NothingIsMadeOfNothing) {
  // Goal: no checkpoint where nothing is reached, in the first half second, or where none are
  // asked for. Method: offers of each kind.
  std::atomic<int> made = 0;
  const auto derive = [&](const Reached&, const std::atomic<bool>&) { ++made; };
  {
    Checkpoints none(derive, clock_, 0);
    clock_.advance(100);
    none.offer({.scans = 5}, true);
  }
  Checkpoints checkpoints(derive, clock_, 60);
  checkpoints.offer({.scans = 5}, true);
  clock_.advance(100);
  checkpoints.offer({}, true);
  checkpoints.stop();
  checkpoints.offer({.scans = 5}, true);
  EXPECT_EQ(made, 0);
}

TEST_F(CheckpointsTest, NobodyWaitsAndOneIsMadeAtATime) {
  // Goal: offers return while one is being made, and begin no second one; stop() gives it up.
  // Method: a checkpoint that goes on until it is told to stop.
  std::atomic<int> begun = 0;
  std::atomic<bool> was_told = false;
  Checkpoints checkpoints(
      [&](const Reached&, const std::atomic<bool>& stop) {
        ++begun;
        while (!stop)
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        was_told = true;
        throw DeriveStopped();
      },
      clock_, 60);
  clock_.advance(1);
  checkpoints.offer({.scans = 1}, true);
  await([&] { return begun == 1; });
  for (std::uint64_t scans = 2; scans < 100; ++scans) {
    clock_.advance(100);
    checkpoints.offer({.scans = scans}, true);
  }
  EXPECT_FALSE(was_told);
  checkpoints.stop();
  EXPECT_TRUE(was_told);
  EXPECT_EQ(begun, 1);
  EXPECT_EQ(checkpoints.made(), 0U);
}

TEST_F(CheckpointsTest, CostlyOnesAreRare) {
  // Goal: deriving takes at most a hundredth of the time. Method: a checkpoint that computes for
  // 0.2 s; the next one comes 20 s later, though one is wanted each second.
  std::atomic<int> begun = 0;
  Checkpoints checkpoints(
      [&](const Reached&, const std::atomic<bool>&) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
        while (std::chrono::steady_clock::now() < end) {
        }
        ++begun;
      },
      clock_, 1);
  clock_.advance(1);
  checkpoints.offer({.scans = 1}, true);
  await([&] { return checkpoints.made() == 1; });
  for (int second = 0; second < 5; ++second) {
    clock_.advance(1);
    checkpoints.offer({.scans = 2}, true);
  }
  EXPECT_EQ(begun, 1);
  clock_.advance(100);
  checkpoints.offer({.scans = 3}, true);
  await([&] { return checkpoints.made() == 2; });
}

TEST_F(CheckpointsTest, OneThatFailsIsTriedAgain) {
  // Goal: a failure ends nothing: the next one is tried. Method: the first fails.
  std::atomic<int> begun = 0;
  Checkpoints checkpoints(
      [&](const Reached&, const std::atomic<bool>&) {
        if (++begun == 1) throw base::Error("disk full");
      },
      clock_, 60);
  clock_.advance(1);
  checkpoints.offer({.scans = 1}, true);
  await([&] { return begun == 1; });
  clock_.advance(61);
  await([&] {
    clock_.advance(1);
    checkpoints.offer({.scans = 2}, true);
    return checkpoints.made() == 1;
  });
  EXPECT_EQ(begun, 2);
}

}  // namespace
}  // namespace sleight::coordinator
