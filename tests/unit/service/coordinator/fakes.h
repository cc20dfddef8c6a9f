// A crew that computes nothing. The crew's results are the store's examples, and its clock is
// manual.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/clock.h"
#include "service/coordinator/crew.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::coordinator::testing {

struct FakeCrewOptions {
  std::uint32_t workers = 1;
  std::uint32_t threads = 3;    ///< of each worker
  double seconds_per_scan = 0;  ///< passes on the clock when an assignment completes
  /// The reported cost of a unit. Empty: the seconds above.
  std::function<double(const plan::Unit&)> cost_s{};
  /// Takes the number of waiting assignments. Returns the index of the assignment that completes
  /// next. Empty: the oldest.
  std::function<std::size_t(std::size_t)> choose{};
  /// Called before each unit completes. May throw, as a failing worker would.
  std::function<void(const plan::Unit&)> before{};
  /// Returns true if the worker has lost the state that the scheduler expects it to hold. Empty:
  /// never.
  std::function<bool(const plan::Unit&)> forgets{};
  /// From this time on, no assignment completes.
  double hangs_from_s = std::numeric_limits<double>::infinity();
};

/// Completes one assignment per receive. Checks that each unit comes with the bytes of the
/// preceding state. If the worker made this state last and hasn't reported its loss, the bytes are
/// not needed. Checks that no worker has more assignments than the scheduler may give.
class FakeCrew final : public Crew {
 public:
  FakeCrew(base::ManualClock& clock, FakeCrewOptions options)
      : clock_(clock), options_(std::move(options)) {}

  std::vector<core::Joined> members() const override {
    std::vector<core::Joined> all;
    for (std::uint32_t i = 0; i < options_.workers; ++i)
      all.push_back({.worker = core::WorkerId{i}, .incarnation = 0, .threads = options_.threads});
    return all;
  }

  void send(core::WorkerId worker, schema::Assignment assignment) override {
    CHECK_LT(worker.value, options_.workers);
    CHECK_LT(before_[worker]++, 2 * options_.threads);
    CHECK_EQ(assignment.block.members.size(), 1U);
    CHECK_EQ(assignment.states.size(), 1U);
    const plan::Unit& unit = assignment.block.members.front();
    check_state(worker, unit, assignment.states.front());
    submitted_.push_back(unit);
    waiting_.push_back({.worker = worker, .assignment = std::move(assignment)});
  }
  void send(core::WorkerId worker, const schema::Ping& ping) override {
    ++pings_;
    schema::Pong pong{.epoch = ping.epoch, .assignments = {}};
    for (const Waiting& one : waiting_) {
      if (one.worker == worker) pong.assignments.push_back(one.assignment.assignment);
    }
    answers_.emplace_back(core::Answered{.worker = worker, .pong = std::move(pong)});
  }

  std::vector<core::Input> receive(double timeout_s) override {
    std::vector<core::Input> inputs = std::exchange(answers_, {});
    if (waiting_.empty()) return inputs;
    if (clock_.now_s() >= options_.hangs_from_s) {
      clock_.advance(timeout_s);
      return inputs;
    }
    const std::size_t which = options_.choose ? options_.choose(waiting_.size()) : 0;
    const Waiting done = waiting_.at(which);
    waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(which));
    inputs.emplace_back(
        core::Delivered{.worker = done.worker, .delivery = run(done.worker, done.assignment)});
    --before_[done.worker];
    return inputs;
  }

  Traffic traffic() const override {
    return {.messages = submitted_.size(), .bytes = 100 * submitted_.size()};
  }

  /// Assignments that aren't completed.
  std::size_t outstanding() const { return waiting_.size(); }
  /// All units in the order of submission.
  const std::vector<plan::Unit>& submitted() const { return submitted_; }
  /// Number of units that came without state bytes. A replica's first unit doesn't count.
  std::uint64_t states_held() const { return states_held_; }
  std::uint64_t states_given() const { return states_given_; }
  std::uint64_t deliveries(core::WorkerId worker) const { return deliveries_.at(worker); }
  std::uint64_t pings() const { return pings_; }

 private:
  struct Waiting {
    core::WorkerId worker;
    schema::Assignment assignment;
  };
  struct Made {
    core::WorkerId worker;
    std::uint64_t version = 0;  ///< the state is the one before this scan
  };

  void check_state(core::WorkerId worker, const plan::Unit& unit, const plan::GivenState& state) {
    if (unit.starts) {
      CHECK(!state);
      return;
    }
    const auto made = made_.find(unit.replica);
    const bool holds = made != made_.end() && made->second.worker == worker &&
                       made->second.version == unit.first_scan.value;
    CHECK_EQ(state.has_value(), !holds);
    (holds ? states_held_ : states_given_) += 1;
    if (!state) return;
    CHECK(*state == store::testing::state_before(unit.replica.chain.value, unit.first_scan.value));
  }

  schema::Delivery run(core::WorkerId worker, const schema::Assignment& assignment) {
    const plan::Unit& unit = assignment.block.members.front();
    schema::Delivery delivery{.epoch = assignment.epoch,
                              .assignment = assignment.assignment,
                              .results = {},
                              .cache = cache_after(worker)};
    const bool needs_held = !unit.starts && !assignment.states.front();
    if (needs_held && options_.forgets && options_.forgets(unit)) {
      made_.erase(unit.replica);
      return delivery;
    }
    if (options_.before) options_.before(unit);
    const double seconds = options_.seconds_per_scan * unit.scans;
    clock_.advance(seconds);
    plan::UnitResult result =
        store::testing::result_of(unit.replica.chain.value, unit.first_scan.value, unit.scans);
    result.unit = unit;
    result.cost_s = options_.cost_s ? options_.cost_s(unit) : seconds;
    result.simulations = 2 * unit.scans + 1;
    made_[unit.replica] = {.worker = worker, .version = unit.first_scan.value + unit.scans};
    delivery.results.push_back(std::move(result));
    return delivery;
  }

  /// Returns cache numbers that are proportional to worker + 1. All numbers except `bytes_max` are
  /// also proportional to the number of the worker's deliveries.
  plan::CacheUse cache_after(core::WorkerId worker) {
    const std::uint64_t n = ++deliveries_[worker];
    const std::uint64_t factor = worker.value + 1;
    return {.hits = n * factor,
            .misses = 10 * n * factor,
            .evictions = 100 * n * factor,
            .bytes = 1000 * n * factor,
            .bytes_max = 10'000 * factor};
  }

  base::ManualClock& clock_;
  FakeCrewOptions options_;
  std::deque<Waiting> waiting_;
  std::vector<core::Input> answers_;
  std::vector<plan::Unit> submitted_;
  std::map<core::WorkerId, std::uint32_t> before_;  ///< number of assignments
  std::map<core::WorkerId, std::uint64_t> deliveries_;
  std::map<plan::ReplicaKey, Made> made_;
  std::uint64_t states_held_ = 0;
  std::uint64_t states_given_ = 0;
  std::uint64_t pings_ = 0;
};

}  // namespace sleight::coordinator::testing
