// Tests of the scheduler with workers and messages that fail at random.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "service/core/scheduler.h"
#include "tests/support/property.h"
#include "tests/tempering/slow_ladder.h"
#include "tests/unit/worker/sampling/any_plan.h"
#include "worker/sampling/independent_chains.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"

namespace sleight::core {
namespace {

using sampling::Dice;

constexpr std::uint64_t k_seed = 550913;
constexpr std::uint64_t k_cases = 400;
constexpr std::uint32_t k_workers = 4;

struct Case {
  bool tempers = false;
  std::uint32_t chains = 1;
  sampling::LadderOptions ladder;
  sampling::StopRule stop;
  SchedulerOptions scheduler;

  std::unique_ptr<plan::Plan> plan() const {
    if (tempers) {
      return std::make_unique<sampling::ParallelTempering>(
          sampling::ParallelTemperingOptions{.ladders = chains, .ladder = ladder, .stop = stop});
    }
    return std::make_unique<sampling::IndependentChains>(sampling::IndependentChainsOptions{
        .chains = chains, .round_scans = ladder.round_scans, .anneal_scans = 0, .stop = stop});
  }
};

Case random_case(Dice& dice) {
  Case made;
  made.tempers = dice.once_in(2);
  made.chains = static_cast<std::uint32_t>(1 + dice.below(made.tempers ? 4 : 8));
  made.ladder.first_ladder = sampling::first_ladder(static_cast<std::uint32_t>(2 + dice.below(5)));
  made.ladder.levels_max = 8;
  made.ladder.round_scans = 1 + dice.below(20);
  made.stop.scans = 1 + dice.below(made.tempers ? 100 : 300);
  if (dice.once_in(2)) made.stop.independent_solutions = 1 + dice.below(10);
  made.scheduler.epoch = 1 + dice.below(3);
  made.scheduler.blocks_ahead = static_cast<std::uint32_t>(dice.below(3));
  made.scheduler.lease_s = 10;
  made.scheduler.size.target_s = 0.001 * static_cast<double>(1 + dice.below(100));
  return made;
}

/// Counts what happened in a test, to check that every case occurred.
struct Happened {
  Counts counts;
  std::uint64_t lost = 0;  ///< lost messages
  std::uint64_t doubled = 0;
  std::uint64_t joined_anew = 0;
  std::uint64_t came_back = 0;  ///< joins with the same incarnation
  std::uint64_t left = 0;
  std::uint64_t asked = 0;
  std::uint64_t several = 0;  ///< blocks of more than one member
};

/// A scheduler, its workers and the messages in transit. After every input, the scheduler's
/// invariants are checked.
class Scene {
 public:
  Scene(const Case& given, const plan::UnitWorker& numbers, Dice& dice, Happened& happened)
      : given_(given),
        numbers_(numbers),
        dice_(dice),
        happened_(happened),
        plan_(given.plan()),
        scheduler_(*plan_, given.scheduler) {
    workers_.resize(k_workers);
    now_s_ = dice.once_in(2) ? 0 : 1e5;
    join(0, true);
  }

  void anything() {
    switch (dice_.below(12)) {
      case 0:
        time_passes(dice_.once_in(4) ? 12 : 0.5);
        break;
      case 1:
        if (dice_.once_in(3)) join(dice_.below(k_workers), dice_.once_in(2));
        break;
      case 2:
        if (dice_.once_in(8)) leave(dice_.below(k_workers));
        break;
      case 3:
      case 4:
      case 5:
      case 6:
        run_one(dice_.below(k_workers));
        break;
      default:
        arrive();
    }
  }

  /// Continues without faults until the scheduler has ended and expects nothing from any worker. If
  /// nothing else happens, time advances.
  void all_goes_well() {
    all_well_ = true;
    for (std::uint32_t id = 0; id < k_workers; ++id) {
      if (!workers_[id].is_there) join(id, true);
    }
    for (std::uint64_t step = 0; step < 10'000 && !is_over(); ++step) {
      bool ran = false;
      for (std::uint32_t id = 0; id < k_workers; ++id)
        ran = run_one(id) || ran;
      while (!under_way_.empty())
        arrive();
      if (!ran) time_passes(30);
      if (::testing::Test::HasFailure()) return;
    }
    EXPECT_TRUE(is_over());
  }

  void stop() { step(StopAsked{}); }
  bool plan_finished() const { return plan_->finished(); }
  std::uint64_t assigned() const { return next_assignment_; }
  const Scheduler& scheduler() const { return scheduler_; }
  const std::map<sampling::Place, plan::ScanRecord>& kept() const { return kept_; }

 private:
  struct Worker {
    bool is_there = false;
    std::uint64_t incarnation = 0;
    std::uint32_t threads = 1;
    std::unique_ptr<sampling::RecordingWorker> memory;
    std::vector<schema::Assignment> before_it;
    std::set<sampling::Place> made;  ///< replica and next scan of each state that it made
    // The scheduler should know the fields below.
    bool joined = false;
    bool silent = false;
    std::set<std::uint64_t> given;
    std::uint64_t asked_up_to = 0;
  };

  bool is_over() const { return scheduler_.ended() && scheduler_.given_out() == 0; }

  void step(const Input& input) {
    if (const auto* delivered = std::get_if<Delivered>(&input)) forget(delivered->delivery);
    const std::uint64_t refused = scheduler_.counts().refused;
    const std::size_t kept = kept_.size();
    bool assigned = false;
    for (const Effect& effect : scheduler_.step(input)) {
      if (const auto* keep = std::get_if<Keep>(&effect)) {
        EXPECT_FALSE(assigned) << "kept after something was assigned";
        take(*keep);
      } else if (const auto* ask = std::get_if<Ask>(&effect)) {
        take(*ask);
      } else {
        take(std::get<Assign>(effect));
        assigned = true;
      }
    }
    if (scheduler_.counts().refused > refused) {
      EXPECT_EQ(kept_.size(), kept);
    }
    std::size_t given = 0;
    std::uint64_t threads = 0;
    for (const Worker& worker : workers_) {
      given += worker.given.size();
      threads += worker.joined && !worker.silent ? worker.threads : 0;
    }
    EXPECT_EQ(scheduler_.given_out(), given);
    EXPECT_EQ(scheduler_.threads(), threads);
  }

  void take(const Keep& keep) {
    for (const plan::UnitResult& result : keep.results) {
      std::uint64_t& next = next_scan_[result.unit.replica];
      // If a ladder adds a replica later, the replica starts at a later scan.
      if (result.unit.starts) next = result.unit.first_scan.value;
      EXPECT_EQ(result.unit.first_scan.value, next);
      for (const plan::ScanRecord& record : result.scans)
        EXPECT_TRUE(kept_.emplace(sampling::Place{result.unit.replica, next++}, record).second);
      states_[result.unit.replica] = result.state_after;
    }
    happened_.several += keep.results.size() > 1 ? 1 : 0;
  }

  void take(const Ask& ask) {
    ++happened_.asked;
    Worker& worker = workers_[ask.worker.value];
    EXPECT_TRUE(worker.joined);
    worker.silent = true;
    worker.asked_up_to = next_assignment_;
    if (!worker.is_there || lost()) return;
    schema::Pong pong{.epoch = given_.scheduler.epoch, .assignments = {}};
    for (const schema::Assignment& assignment : worker.before_it)
      pong.assignments.push_back(assignment.assignment);
    under_way_.emplace_back(Answered{.worker = ask.worker, .pong = pong});
  }

  void take(const Assign& assign) {
    const schema::Assignment& assignment = assign.assignment;
    Worker& worker = workers_[assign.worker.value];
    EXPECT_EQ(assignment.assignment, next_assignment_++);
    EXPECT_TRUE(worker.joined);
    EXPECT_FALSE(worker.silent);
    worker.given.insert(assignment.assignment);
    EXPECT_LE(worker.given.size(), worker.threads * (1 + given_.scheduler.blocks_ahead));
    for (std::size_t i = 0; i < assignment.states.size(); ++i) {
      const plan::Unit& member = assignment.block.members[i];
      if (assignment.states[i]) {
        EXPECT_EQ(*assignment.states[i], states_.at(member.replica));
      } else if (!member.starts && worker.is_there) {
        EXPECT_TRUE(worker.made.contains({member.replica, member.first_scan.value}));
      }
    }
    if (worker.is_there && !lost()) worker.before_it.push_back(assignment);
  }

  /// A delivery ends its assignment.
  void forget(const schema::Delivery& delivery) {
    if (delivery.epoch != given_.scheduler.epoch) return;
    for (Worker& worker : workers_)
      worker.given.erase(delivery.assignment);
  }

  bool lost() {
    if (all_well_ || !dice_.once_in(6)) return false;
    ++happened_.lost;
    return true;
  }

  void join(std::uint64_t id, bool anew) {
    Worker& worker = workers_[id];
    if (!worker.is_there || anew) {
      ++happened_.joined_anew;
      ++worker.incarnation;
      worker.is_there = true;
      worker.threads = static_cast<std::uint32_t>(1 + dice_.below(3));
      worker.memory = std::make_unique<sampling::RecordingWorker>(numbers_);
      worker.before_it.clear();
      worker.made.clear();
      worker.given.clear();
      worker.asked_up_to = 0;
    } else {
      ++happened_.came_back;
    }
    worker.joined = true;
    worker.silent = false;
    step(Joined{.worker = WorkerId{static_cast<std::uint32_t>(id)},
                .incarnation = worker.incarnation,
                .threads = worker.threads});
  }

  void leave(std::uint64_t id) {
    ++happened_.left;
    Worker gone;
    gone.incarnation = workers_[id].incarnation;
    workers_[id] = std::move(gone);
    step(Left{WorkerId{static_cast<std::uint32_t>(id)}});
  }

  void time_passes(double most_s) {
    now_s_ += most_s * static_cast<double>(1 + dice_.below(100)) / 100;
    step(Tick{now_s_});
  }

  /// Runs a random assignment of the worker.
  bool run_one(std::uint64_t id) {
    Worker& worker = workers_[id];
    if (!worker.is_there || worker.before_it.empty()) return false;
    const std::size_t which = dice_.below(worker.before_it.size());
    const schema::Assignment assignment = std::move(worker.before_it[which]);
    worker.before_it.erase(worker.before_it.begin() + static_cast<std::ptrdiff_t>(which));
    // Sometimes the worker loses all its states.
    if (dice_.once_in(10)) worker.memory = std::make_unique<sampling::RecordingWorker>(numbers_);
    const sampling::BlockRunner runner(*worker.memory, clock_);
    Delivered made{.worker = WorkerId{static_cast<std::uint32_t>(id)},
                   .delivery = {.epoch = assignment.epoch,
                                .assignment = assignment.assignment,
                                .results = runner.run(assignment.block, assignment.states),
                                .cache = {}}};
    for (plan::UnitResult& result : made.delivery.results)
      result.cost_s = 0.001 * result.unit.scans;
    for (const plan::UnitResult& result : made.delivery.results)
      worker.made.insert({result.unit.replica, result.unit.first_scan.value + result.unit.scans});
    if (lost()) return true;
    if (!all_well_ && dice_.once_in(10)) {
      ++happened_.doubled;
      under_way_.emplace_back(made);
    }
    if (!all_well_ && dice_.once_in(10)) spoil(made.delivery);
    under_way_.emplace_back(std::move(made));
    return true;
  }

  void spoil(schema::Delivery& delivery) {
    if (delivery.results.empty() || dice_.once_in(4)) {
      delivery.epoch += 1;
    } else if (dice_.once_in(3)) {
      delivery.results.pop_back();
      if (delivery.results.empty()) delivery.epoch += 1;
    } else if (dice_.once_in(2)) {
      ++delivery.results.back().unit.first_scan.value;
    } else {
      delivery.results.front().scans.pop_back();
    }
  }

  /// Delivers a random message in transit.
  void arrive() {
    if (under_way_.empty()) return;
    const std::size_t which = dice_.below(under_way_.size());
    const Input input = std::move(under_way_[which]);
    under_way_.erase(under_way_.begin() + static_cast<std::ptrdiff_t>(which));
    if (const auto* delivered = std::get_if<Delivered>(&input)) {
      workers_[delivered->worker.value].silent = false;
    } else {
      const auto& answered = std::get<Answered>(input);
      Worker& worker = workers_[answered.worker.value];
      worker.silent = false;
      const std::set<std::uint64_t> has(answered.pong.assignments.begin(),
                                        answered.pong.assignments.end());
      std::erase_if(worker.given, [&](std::uint64_t assignment) {
        return assignment < worker.asked_up_to && !has.contains(assignment);
      });
    }
    step(input);
  }

  const Case& given_;
  const plan::UnitWorker& numbers_;
  Dice& dice_;
  Happened& happened_;
  std::unique_ptr<plan::Plan> plan_;
  Scheduler scheduler_;
  base::ManualClock clock_;
  std::vector<Worker> workers_;
  std::vector<Input> under_way_;
  bool all_well_ = false;
  double now_s_ = 0;
  std::uint64_t next_assignment_ = 0;
  std::map<plan::ReplicaKey, std::uint64_t> next_scan_;
  std::map<plan::ReplicaKey, base::Bytes> states_;
  std::map<sampling::Place, plan::ScanRecord> kept_;
};

sampling::ScanByScan numbers_of(Dice& dice) {
  return sampling::ScanByScan({.seed = dice.below(1000),
                               .roughness = {0.1, 2, 12, 60},
                               .broken = dice.once_in(2) ? 0 : 0.2,
                               .satisfied = dice.once_in(2) ? 0.02 : 0.3});
}

void add(Happened& happened, const Counts& counts) {
  happened.counts.blocks += counts.blocks;
  happened.counts.copies += counts.copies;
  happened.counts.refused += counts.refused;
  happened.counts.states_sent += counts.states_sent;
  happened.counts.states_held += counts.states_held;
  happened.counts.states_missing += counts.states_missing;
}

TEST(SchedulerProperty, FinishesWithTheSerialRunsResults) {
  // Goal: even if messages are lost, repeated, late or corrupt, each scan is kept once and in
  // order. No worker gets more assignments than its limit. When the faults end, the run finishes
  // with the results of a serial run. Method: run chains and ladders on workers that join and leave
  // at random. The test lists each worker's assignments, and compares the list with the scheduler's
  // counts. Check that faults of each kind occurred.
  Happened happened;
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(k_seed, index);
    const Case given = random_case(dice);
    const sampling::ScanByScan numbers = numbers_of(dice);
    const auto serial_plan = given.plan();
    sampling::AnySession serial(*serial_plan, numbers);
    serial.run_serially();

    Scene scene(given, numbers, dice, happened);
    for (std::uint64_t steps = dice.below(2000); steps > 0 && !HasFailure(); --steps)
      scene.anything();
    scene.all_goes_well();
    EXPECT_TRUE(scene.plan_finished());
    EXPECT_EQ(scene.kept().size(), serial.runs().size());
    for (const auto& [place, record] : scene.kept())
      ASSERT_EQ(record, serial.runs().at(place).record);
    add(happened, scene.scheduler().counts());
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  const Counts& counts = happened.counts;
  for (const std::uint64_t count :
       {counts.blocks, counts.copies, counts.refused, counts.states_sent, counts.states_held,
        counts.states_missing, happened.lost, happened.doubled, happened.joined_anew,
        happened.came_back, happened.left, happened.asked, happened.several})
    EXPECT_GT(count, k_cases / 2);
}

TEST(SchedulerProperty, EndsAfterAStop) {
  // Goal: after a stop, nothing more is assigned. The run ends once workers have delivered or their
  // leases have ended. Method: run random cases with faults. Stop after a random number of steps.
  Happened happened;
  std::uint64_t kept_after = 0;
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(k_seed, k_cases + index);
    const Case given = random_case(dice);
    const sampling::ScanByScan numbers = numbers_of(dice);
    Scene scene(given, numbers, dice, happened);
    for (std::uint64_t steps = dice.below(300); steps > 0 && !HasFailure(); --steps)
      scene.anything();
    scene.stop();
    const std::uint64_t kept = scene.scheduler().counts().blocks;
    const std::uint64_t assigned = scene.assigned();
    scene.all_goes_well();
    EXPECT_EQ(scene.assigned(), assigned);
    kept_after += scene.scheduler().counts().blocks - kept;
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(kept_after, k_cases / 4);
}

}  // namespace
}  // namespace sleight::core
