#include "service/coordinator/local_executor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <set>

#include "common/base/error.h"

namespace sleight::coordinator {
namespace {

/// A worker that does what a test says.
class FakeWorker final : public plan::UnitWorker {
 public:
  using Act = std::function<void(const plan::Unit&, base::BytesView)>;
  explicit FakeWorker(Act act = {}) : act_(std::move(act)) {}

  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override {
    ++started_;
    if (act_) act_(unit, state);
    return {.unit = unit, .scans = {}, .state_after = {state.begin(), state.end()}};
  }
  int started() const { return started_; }

 private:
  Act act_;
  mutable std::atomic<int> started_{0};
};

plan::Unit unit(std::uint32_t chain) {
  return {.replica = {base::ChainId{chain}, base::ReplicaId{0}}, .first_scan = {}, .scans = 1};
}

/// Waits until a number of results has come.
std::vector<plan::UnitResult> collect(LocalExecutor& executor, std::size_t count) {
  std::vector<plan::UnitResult> all;
  while (all.size() < count) {
    for (plan::UnitResult& result : executor.wait(10))
      all.push_back(std::move(result));
  }
  return all;
}

/// A gate that holds workers up.
class Gate {
 public:
  void pass() {
    ++waiting_;
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return open_; });
  }
  void open() {
    const std::scoped_lock lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  void await(int count) const {
    while (waiting_ < count)
      std::this_thread::yield();
  }

 private:
  std::atomic<int> waiting_{0};
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
};

TEST(LocalExecutor, ComputesEveryUnitOnce) {
  // Goal: each unit comes back once, with its own state. Method: 500 units through 3 threads.
  const FakeWorker worker;
  const base::SteadyClock clock;
  LocalExecutor executor(worker, clock, 3);
  EXPECT_EQ(executor.workers(), 3U);
  for (std::uint32_t i = 0; i < 500; ++i)
    executor.submit(unit(i), base::Bytes(i));
  EXPECT_EQ(executor.outstanding(), 500U);
  std::set<std::uint32_t> seen;
  for (const plan::UnitResult& result : collect(executor, 500)) {
    EXPECT_TRUE(seen.insert(result.unit.replica.chain.value).second);
    EXPECT_EQ(result.state_after.size(), result.unit.replica.chain.value);
    EXPECT_GE(result.cost_s, 0);
  }
  EXPECT_EQ(executor.outstanding(), 0U);
  EXPECT_EQ(worker.started(), 500);
}

TEST(LocalExecutor, RoomIsTwoUnitsAThread) {
  // Goal: room counts down with submitted units and never below zero. Method: fill it and more.
  Gate gate;
  const FakeWorker worker([&](const auto&, auto) { gate.pass(); });
  const base::SteadyClock clock;
  LocalExecutor executor(worker, clock, 2);
  for (std::uint32_t i = 0; i < 6; ++i) {
    EXPECT_EQ(executor.room(), i < 4 ? 4 - i : 0);
    executor.submit(unit(i), {});
  }
  EXPECT_TRUE(executor.wait(0).empty());
  EXPECT_EQ(executor.outstanding(), 6U);
  gate.open();
  (void)collect(executor, 6);
  EXPECT_EQ(executor.room(), 4U);
}

TEST(LocalExecutor, ThreadsWorkAtTheSameTime) {
  // Goal: as many units run at once as there are threads. Method: units that wait for each other;
  // fewer threads would wait for ever.
  Gate gate;
  const FakeWorker worker([&](const auto&, auto) { gate.pass(); });
  const base::SteadyClock clock;
  LocalExecutor executor(worker, clock, 4);
  for (std::uint32_t i = 0; i < 4; ++i)
    executor.submit(unit(i), {});
  gate.await(4);
  gate.open();
  EXPECT_EQ(collect(executor, 4).size(), 4U);
}

TEST(LocalExecutor, WaitEndsWithoutResults) {
  // Goal: a time-out returns nothing and loses nothing. Method: wait while the worker is held up,
  // then after it is released.
  Gate gate;
  const FakeWorker worker([&](const auto&, auto) { gate.pass(); });
  const base::SteadyClock clock;
  LocalExecutor executor(worker, clock, 1);
  executor.submit(unit(0), {});
  EXPECT_TRUE(executor.wait(0.02).empty());
  EXPECT_EQ(executor.outstanding(), 1U);
  gate.open();
  EXPECT_EQ(collect(executor, 1).size(), 1U);
}

TEST(LocalExecutor, WorkersExceptionComesOutOfWait) {
  // Goal: a failure in a thread reaches the driver as what it was, again if need be, and doesn't
  // end the process. Method: the third of five units throws.
  const FakeWorker worker([](const plan::Unit& failing, auto) {
    if (failing.replica.chain.value == 2) {
      throw base::Error(base::ExitCode::environment, "no memory");
    }
  });
  const base::SteadyClock clock;
  LocalExecutor executor(worker, clock, 2);
  for (std::uint32_t i = 0; i < 5; ++i)
    executor.submit(unit(i), {});
  std::string reason;
  while (reason.empty()) {
    try {
      (void)executor.wait(10);
    } catch (const base::Error& error) {
      reason = error.what();
    }
  }
  EXPECT_EQ(reason, "no memory");
  EXPECT_THROW((void)executor.wait(0), base::Error);
}

TEST(LocalExecutor, DestructorDropsWhatWaits) {
  // Goal: leaving lets running units end and starts no other. Method: one thread held up in the
  // first of a hundred units while another thread destroys the executor.
  Gate gate;
  const FakeWorker worker([&](const auto&, auto) { gate.pass(); });
  const base::SteadyClock clock;
  auto executor = std::make_unique<LocalExecutor>(worker, clock, 1);
  for (std::uint32_t i = 0; i < 100; ++i)
    executor->submit(unit(i), {});
  gate.await(1);
  std::thread destroyer([&] { executor.reset(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  gate.open();
  destroyer.join();
  EXPECT_LE(worker.started(), 2);
}

TEST(LocalExecutor, CostIsMeasuredByItsClock) {
  // Goal: cost_s is the time between begin and end of a unit. Method: a clock that the worker
  // moves.
  base::ManualClock clock;
  const FakeWorker worker([&](const auto&, auto) { clock.advance(2.5); });
  LocalExecutor executor(worker, clock, 1);
  executor.submit(unit(0), {});
  EXPECT_EQ(collect(executor, 1).at(0).cost_s, 2.5);
}

}  // namespace
}  // namespace sleight::coordinator
