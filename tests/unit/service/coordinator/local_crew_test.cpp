#include "service/coordinator/local_crew.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "common/base/clock.h"
#include "common/base/error.h"
#include "worker/sampling/block_runner.h"

namespace sleight::coordinator {
namespace {

using ::testing::ElementsAre;

/// A worker that runs a test's function.
class FakeWorker final : public plan::BlockWorker {
 public:
  using Act = std::function<void(const plan::Unit&)>;
  explicit FakeWorker(Act act = {}) : act_(std::move(act)) {}

  /// Returns each member's given state as its result. If a state is missing, returns no results.
  std::vector<plan::UnitResult> run(const plan::Block& block,
                                    std::span<const plan::GivenState> states) const override {
    ++started_;
    std::vector<plan::UnitResult> results;
    for (std::size_t i = 0; i < block.members.size(); ++i) {
      if (act_) act_(block.members[i]);
      if (!states[i]) return {};
      results.push_back({.unit = block.members[i], .scans = {}, .state_after = *states[i]});
    }
    return results;
  }
  plan::CacheUse cache_use() const override {
    return {.hits = 1, .misses = 2, .evictions = 3, .bytes = 4, .bytes_max = 5};
  }
  int started() const { return started_; }

 private:
  Act act_;
  mutable std::atomic<int> started_{0};
};

plan::Unit unit(std::uint32_t chain) {
  return {.replica = {base::ChainId{chain}, base::ReplicaId{0}}, .first_scan = {}, .scans = 1};
}

schema::Assignment assignment(std::uint64_t number, base::Bytes state = {}) {
  const auto chain = static_cast<std::uint32_t>(number);
  return {.epoch = 9,
          .assignment = number,
          .block = {.members = {unit(chain)}, .ladder = {}},
          .states = {std::move(state)}};
}

/// Waits for the next `count` deliveries and returns them.
std::vector<schema::Delivery> collect(LocalCrew& crew, std::size_t count) {
  std::vector<schema::Delivery> all;
  while (all.size() < count) {
    for (core::Input& input : crew.receive(10)) {
      auto& delivered = std::get<core::Delivered>(input);
      EXPECT_EQ(delivered.worker, k_local_worker);
      all.push_back(std::move(delivered.delivery));
    }
  }
  return all;
}

/// Returns the assignments that the crew reports as unfinished.
std::vector<std::uint64_t> before(LocalCrew& crew) {
  crew.send(k_local_worker, schema::Ping{.epoch = 9});
  const std::vector<core::Input> inputs = crew.receive(10);
  EXPECT_EQ(inputs.size(), 1U);
  const auto& answered = std::get<core::Answered>(inputs.at(0));
  EXPECT_EQ(answered.worker, k_local_worker);
  EXPECT_EQ(answered.pong.epoch, 9U);
  return answered.pong.assignments;
}

/// Blocks workers until the gate is opened.
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

TEST(LocalCrew, IsOneWorkerOfAllThreads) {
  // Goal: the scheduler sees one worker with the requested threads and no network traffic.
  const FakeWorker worker;
  const LocalCrew crew(worker, 3);
  ASSERT_EQ(crew.members().size(), 1U);
  EXPECT_EQ(crew.members()[0].worker, k_local_worker);
  EXPECT_EQ(crew.members()[0].threads, 3U);
  EXPECT_EQ(crew.traffic().messages, 0U);
  EXPECT_EQ(crew.traffic().bytes, 0U);
}

TEST(LocalCrew, ComputesEveryAssignmentOnce) {
  // Goal: each assignment is delivered once, with its number, its epoch, its own state and the
  // worker's cache. Method: send 500 assignments to 3 threads.
  const FakeWorker worker;
  LocalCrew crew(worker, 3);
  for (std::uint32_t i = 0; i < 500; ++i)
    crew.send(k_local_worker, assignment(i, base::Bytes(i)));
  std::set<std::uint64_t> seen;
  for (const schema::Delivery& delivery : collect(crew, 500)) {
    EXPECT_TRUE(seen.insert(delivery.assignment).second);
    EXPECT_EQ(delivery.epoch, 9U);
    EXPECT_EQ(delivery.cache, worker.cache_use());
    ASSERT_EQ(delivery.results.size(), 1U);
    EXPECT_EQ(delivery.results[0].unit.replica.chain.value, delivery.assignment);
    EXPECT_EQ(delivery.results[0].state_after.size(), delivery.assignment);
  }
  EXPECT_TRUE(before(crew).empty());
  EXPECT_EQ(worker.started(), 500);
}

TEST(LocalCrew, BlocksComeBackWhole) {
  // Goal: a block's members and states reach the worker unchanged. The delivery reaches the driver,
  // even if it has no results. Method: send a block of three members twice. The second time, one
  // state is missing.
  const FakeWorker worker;
  LocalCrew crew(worker, 1);
  schema::Assignment block = assignment(1);
  block.block.members = {unit(4), unit(5), unit(6)};
  block.states = {base::Bytes(4), base::Bytes(5), base::Bytes(6)};
  crew.send(k_local_worker, block);
  const schema::Delivery whole = collect(crew, 1).at(0);
  ASSERT_EQ(whole.results.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(whole.results[i].unit, block.block.members[i]);
    EXPECT_EQ(whole.results[i].state_after.size(), 4 + i);
  }
  block.assignment = 2;
  block.states[1].reset();
  crew.send(k_local_worker, block);
  const schema::Delivery missing = collect(crew, 1).at(0);
  EXPECT_EQ(missing.assignment, 2U);
  EXPECT_TRUE(missing.results.empty());
}

TEST(LocalCrew, AnswersPingsWithWhatIsBeforeIt) {
  // Goal: a ping is answered at once with a list of exactly the running and waiting assignments.
  // Method: send six assignments to two blocked threads, then release the threads.
  Gate gate;
  const FakeWorker worker([&](const auto&) { gate.pass(); });
  LocalCrew crew(worker, 2);
  EXPECT_TRUE(before(crew).empty());
  for (std::uint32_t i = 0; i < 6; ++i)
    crew.send(k_local_worker, assignment(i));
  gate.await(2);
  EXPECT_THAT(before(crew), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_TRUE(crew.receive(0).empty());
  gate.open();
  (void)collect(crew, 6);
  EXPECT_TRUE(before(crew).empty());
}

TEST(LocalCrew, TakesTheOldestFirst) {
  // Goal: a thread runs assignments in the order in which they were sent.
  const FakeWorker worker;
  LocalCrew crew(worker, 1);
  for (const std::uint64_t number : {7U, 3U, 9U, 1U})
    crew.send(k_local_worker, assignment(number));
  std::vector<std::uint64_t> order;
  for (const schema::Delivery& delivery : collect(crew, 4))
    order.push_back(delivery.assignment);
  EXPECT_THAT(order, ElementsAre(7, 3, 9, 1));
}

TEST(LocalCrew, ThreadsWorkAtTheSameTime) {
  // Goal: as many assignments run at once as there are threads. Method: run units that wait for
  // each other. If there were fewer threads, they would wait forever.
  Gate gate;
  const FakeWorker worker([&](const auto&) { gate.pass(); });
  LocalCrew crew(worker, 4);
  for (std::uint32_t i = 0; i < 4; ++i)
    crew.send(k_local_worker, assignment(i));
  gate.await(4);
  gate.open();
  EXPECT_EQ(collect(crew, 4).size(), 4U);
}

TEST(LocalCrew, ReceiveEndsWithoutResults) {
  // Goal: after its timeout, receive() returns nothing. A later delivery is not lost. Method: block
  // the worker, then release it.
  Gate gate;
  const FakeWorker worker([&](const auto&) { gate.pass(); });
  LocalCrew crew(worker, 1);
  crew.send(k_local_worker, assignment(0));
  EXPECT_TRUE(crew.receive(0.02).empty());
  EXPECT_THAT(before(crew), ElementsAre(0));
  gate.open();
  EXPECT_EQ(collect(crew, 1).size(), 1U);
}

TEST(LocalCrew, WorkersExceptionComesOutOfReceive) {
  // Goal: if a unit throws an exception, every later receive() throws an exception of the same
  // type. The process doesn't end. Method: let the third of five units throw.
  const FakeWorker worker([](const plan::Unit& failing) {
    if (failing.replica.chain.value == 2) {
      throw base::Error(base::ExitCode::environment, "no memory");
    }
  });
  LocalCrew crew(worker, 2);
  for (std::uint32_t i = 0; i < 5; ++i)
    crew.send(k_local_worker, assignment(i));
  std::string reason;
  while (reason.empty()) {
    try {
      (void)crew.receive(10);
    } catch (const base::Error& error) {
      reason = error.what();
    }
  }
  EXPECT_EQ(reason, "no memory");
  EXPECT_THROW((void)crew.receive(0), base::Error);
}

TEST(LocalCrew, DestructorDropsWhatWaits) {
  // Goal: the destructor waits for running blocks and starts no waiting block. Method: send a
  // hundred assignments. Block the first assignment while another thread destroys the crew.
  Gate gate;
  const FakeWorker worker([&](const auto&) { gate.pass(); });
  auto crew = std::make_unique<LocalCrew>(worker, 1);
  for (std::uint32_t i = 0; i < 100; ++i)
    crew->send(k_local_worker, assignment(i));
  gate.await(1);
  std::atomic<bool> begins = false;
  std::thread destroyer([&] {
    begins = true;
    crew.reset();
  });
  while (!begins)
    std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  gate.open();
  destroyer.join();
  EXPECT_LE(worker.started(), 2);
}

/// A worker that moves a manual clock by 2.5 s for each unit.
class TimedWorker final : public plan::UnitWorker {
 public:
  explicit TimedWorker(base::ManualClock& clock) : clock_(clock) {}
  plan::UnitResult run(const plan::Unit& unit, base::BytesView) const override {
    clock_.advance(2.5);
    return {.unit = unit, .scans = {plan::ScanRecord{}}, .state_after = {}};
  }

 private:
  base::ManualClock& clock_;
};

TEST(LocalCrew, CostIsMeasuredByTheRunnersClock) {
  // Goal: a result's cost_s is the duration of its unit by the runner's clock.
  base::ManualClock clock;
  const TimedWorker worker(clock);
  const sampling::BlockRunner runner(worker, clock);
  LocalCrew crew(runner, 1);
  crew.send(k_local_worker, assignment(0, base::Bytes(1)));
  EXPECT_EQ(collect(crew, 1).at(0).results.at(0).cost_s, 2.5);
}

TEST(LocalCrewDeathTest, ForeignWorkerIsABug) {
  // Goal: if an assignment or a ping is sent to a worker that isn't the local one, a CHECK fails.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const FakeWorker worker;
  LocalCrew crew(worker, 1);
  EXPECT_DEATH(crew.send(core::WorkerId{1}, assignment(0)), "check failed");
  EXPECT_DEATH(crew.send(core::WorkerId{1}, schema::Ping{}), "check failed");
}

}  // namespace
}  // namespace sleight::coordinator
