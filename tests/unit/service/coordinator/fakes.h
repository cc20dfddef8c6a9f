// An executor that computes nothing: results are those of the store's examples, and time is what a
// test says.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/clock.h"
#include "service/coordinator/executor.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::coordinator::testing {

struct FakeExecutorOptions {
  std::size_t room = 4;
  std::size_t begun = 1000;     ///< waiting units that somebody has begun, which can't be dropped
  double seconds_per_scan = 0;  ///< passes on the clock when a unit is waited for
  /// What a unit is said to have cost; the seconds above when empty.
  std::function<double(const plan::Unit&)> cost_s{};
  /// Which of the waiting units completes next, of so many; the oldest when empty.
  std::function<std::size_t(std::size_t)> choose{};
  /// Called before each unit completes; may throw, as a worker's failure would.
  std::function<void(const plan::Unit&)> before{};
};

/// Completes one unit a wait. Checks that each unit comes with the state of the scan before it.
class FakeExecutor final : public Executor {
 public:
  FakeExecutor(base::ManualClock& clock, FakeExecutorOptions options)
      : clock_(clock), options_(std::move(options)) {}

  std::size_t room() const override {
    return waiting_.size() < options_.room ? options_.room - waiting_.size() : 0;
  }
  void submit(const plan::Unit& unit, base::Bytes state) override {
    CHECK_LT(waiting_.size(), options_.room);
    CHECK(state == store::testing::state_before(unit.replica.chain.value, unit.first_scan.value));
    waiting_.push_back(unit);
    submitted_.push_back(unit);
  }
  std::vector<plan::UnitResult> wait(double) override {
    if (waiting_.empty()) return {};
    const std::size_t which = options_.choose ? options_.choose(waiting_.size()) : 0;
    const plan::Unit unit = waiting_.at(which);
    waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(which));
    if (options_.before) options_.before(unit);
    const double seconds = options_.seconds_per_scan * unit.scans;
    clock_.advance(seconds);
    plan::UnitResult result =
        store::testing::result_of(unit.replica.chain.value, unit.first_scan.value, unit.scans);
    result.unit = unit;
    result.cost_s = options_.cost_s ? options_.cost_s(unit) : seconds;
    std::vector<plan::UnitResult> results;
    results.push_back(std::move(result));
    return results;
  }
  void drop_waiting() override { waiting_.resize(std::min(waiting_.size(), options_.begun)); }
  std::size_t outstanding() const override { return waiting_.size(); }
  std::size_t workers() const override { return 3; }

  /// Every unit in the order of submission.
  const std::vector<plan::Unit>& submitted() const { return submitted_; }

 private:
  base::ManualClock& clock_;
  FakeExecutorOptions options_;
  std::deque<plan::Unit> waiting_;
  std::vector<plan::Unit> submitted_;
};

}  // namespace sleight::coordinator::testing
