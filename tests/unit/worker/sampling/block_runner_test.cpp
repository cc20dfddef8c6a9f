// Parallel tempering in blocks against the lockstep reference, bit for bit, however blocks are cut.
#include "worker/sampling/block_runner.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/support/property.h"
#include "tests/unit/worker/sampling/any_plan.h"
#include "tests/unit/worker/sampling/replaced_formulas.h"
#include "tests/unit/worker/sampling/slow_ladder.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_seed = 424243;
constexpr std::uint64_t k_cases = 120;
constexpr std::uint64_t k_scans_max = 260;

struct Case {
  ParallelTemperingOptions options;
  ScanByScan worker;
};

Case random_case(Dice& dice) {
  const std::uint64_t seed = dice.below(1000);
  Case made{.options = {},
            .worker = ScanByScan({.seed = seed,
                                  .roughness = {0.1, 2, 12, 60},
                                  .broken = dice.once_in(2) ? 0 : 0.2,
                                  .satisfied = dice.once_in(2) ? 0.02 : 0.3})};
  made.options.ladders = static_cast<std::uint32_t>(1 + dice.below(3));
  made.options.ladder = {
      .seed = seed,
      .chain = {},
      .first_ladder = first_ladder(static_cast<std::uint32_t>(2 + dice.below(9))),
      .levels_chosen = !dice.once_in(3),
      .levels_max = static_cast<std::uint32_t>(4 + dice.below(20)),
      .ladder_adapts = !dice.once_in(3),
      .has_scale = dice.once_in(3) ? std::vector<bool>{} : std::vector<bool>{true, dice.once_in(2)},
      .round_scans = 1 + dice.below(40),
      .anneal_scans = dice.once_in(2) ? 0 : 1 + dice.below(40)};
  StopRule& stop = made.options.stop;
  if (dice.once_in(2)) stop.independent_solutions = 1 + dice.below(40);
  if (dice.once_in(2)) stop.rounds = static_cast<std::uint32_t>(1 + dice.below(3));
  if (dice.once_in(2) || !stop.rounds) stop.scans = 1 + dice.below(k_scans_max);
  return made;
}

/// What all ladders of a case must come to.
struct Expected {
  std::uint64_t end = 0;
  ScanRuns runs;
  std::vector<SlowLadder> ladders;
};

Expected expected_of(const Case& given) {
  const auto all = [&](std::uint64_t scans) {
    Expected run{.end = scans, .runs = {}, .ladders = {}};
    LadderOptions options = given.options.ladder;
    for (std::uint32_t chain = 0; chain < given.options.ladders; ++chain) {
      options.chain = base::ChainId{chain};
      run.ladders.push_back(slow_ladder(options, given.worker, scans));
      for (const auto& [place, result] : run.ladders.back().results) {
        const plan::Unit unit = alone(result.unit, 0, result.unit.lineage);
        run.runs[{unit.replica, place.second}] = {unit, result.scans.front(), result.state_after};
      }
    }
    return run;
  };
  const LadderOptions& ladder = given.options.ladder;
  const std::uint64_t longest = 2 * k_scans_max;
  return all(scans_at_stop(given.options.stop, ladder.round_scans, ladder.anneal_scans,
                           all(longest).runs));
}

void expect_end(const ParallelTempering& plan, const AnySession& session,
                const Expected& expected) {
  EXPECT_TRUE(plan.finished());
  EXPECT_EQ(plan.scans_common(), expected.end);
  EXPECT_EQ(plan.scans_consumed(), expected.runs.size());
  EXPECT_TRUE(session.runs() == expected.runs);
  for (std::size_t i = 0; i < expected.ladders.size(); ++i) {
    const LadderRun& ladder = plan.ladders()[i];
    const SlowLadder& slow = expected.ladders[i];
    EXPECT_EQ(fingerprint(ladder.rounds(), ladder.solutions().scans()),
              fingerprint(slow.rounds, slow.solutions));
  }
}

TEST(BlockRunner, EqualsTheLockstepReference) {
  // Goal: units, records, states, rounds and the stop are those of the reference, however blocks
  // are cut, wherever they run and in whatever order their members' results arrive. Method: random
  // cases, several random sessions of each; what blocks had in them is counted.
  BlockShapes shapes;
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(k_seed, index);
    const Case given = random_case(dice);
    const Expected expected = expected_of(given);
    for (int repeat = 0; repeat < 3; ++repeat) {
      ParallelTempering plan(given.options);
      AnySession session(plan, given.worker);
      session.run_in_blocks(dice, shapes);
      expect_end(plan, session, expected);
      EXPECT_EQ(plan.next_block({.unit_scans_max = 1, .block_scans_max = 1}), std::nullopt);
      if (HasFailure()) return;
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(shapes.of_several, 10'000U);
  EXPECT_GT(shapes.staggered, 300U);
  EXPECT_GT(shapes.whole, 100U);
  EXPECT_GT(shapes.cut, 1000U);
  EXPECT_GT(shapes.went_on, 10'000U);
  EXPECT_GT(shapes.swapped, 10'000U);
  EXPECT_GT(shapes.left, 1000U);
  EXPECT_GT(shapes.annealing, 100U);
  EXPECT_GT(shapes.held, 1000U);
  EXPECT_GT(shapes.lacking, 1000U);
}

TEST(BlockRunner, GoesOnFromAnyStoredResults) {
  // Goal: a plan that consumes what a stopped session stored, some members of a block further than
  // others, goes on in blocks to the reference's end. Method: stop at a random moment, with what
  // was in flight lost or kept; replay by replicas in any order.
  BlockShapes shapes;
  std::uint64_t in_the_middle = 0;
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(k_seed, k_cases + index);
    const Case given = random_case(dice);
    const Expected expected = expected_of(given);
    ParallelTempering stopped_plan(given.options);
    AnySession stopped(stopped_plan, given.worker);
    stopped.run_in_blocks(dice, shapes, dice.below(300));
    if (dice.once_in(3)) stopped.complete_all(dice);
    if (!stopped_plan.finished() && !stopped.runs().empty()) ++in_the_middle;

    ParallelTempering plan(given.options);
    AnySession resumed(plan, given.worker);
    resumed.replay(stopped.runs(), dice);
    EXPECT_EQ(plan.finished(), stopped_plan.finished());
    EXPECT_EQ(plan.scans_common(), stopped_plan.scans_common());
    EXPECT_EQ(plan.scans_consumed(), stopped_plan.scans_consumed());
    expect_equal(plan.report(), stopped_plan.report());
    resumed.run_in_blocks(dice, shapes);
    expect_end(plan, resumed, expected);
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(in_the_middle, k_cases / 2);
}

ParallelTemperingOptions small_ladder(std::uint32_t levels) {
  ParallelTemperingOptions options;
  options.ladder.first_ladder = first_ladder(levels);
  options.ladder.round_scans = 1000;
  options.stop.scans = 1000;
  return options;
}

/// The block of a whole ladder that has made its first scan, and the states before.
struct SecondScan {
  plan::Block block;
  std::vector<plan::GivenState> states;
};

/// `worker` runs the first scan, and holds its states if it holds any.
SecondScan second_scan(std::uint32_t levels, std::uint32_t scans_max,
                       const plan::UnitWorker& worker) {
  ParallelTempering plan(small_ladder(levels));
  std::map<plan::ReplicaKey, base::Bytes> states;
  // All are handed out before any comes back, so none has its second scan yet.
  std::vector<plan::UnitResult> firsts;
  while (const auto unit = plan.next_unit(1))
    firsts.push_back(worker.run(*unit, {}));
  for (const plan::UnitResult& first : firsts) {
    states[first.unit.replica] = first.state_after;
    plan.consume(first.unit.replica, first.unit.first_scan, first.scans);
  }
  SecondScan made{.block = *plan.next_block({.unit_scans_max = 1, .block_scans_max = scans_max}),
                  .states = {}};
  for (const plan::Unit& member : made.block.members)
    made.states.emplace_back(states.at(member.replica));
  return made;
}

void expect_same(const std::vector<plan::UnitResult>& a, const std::vector<plan::UnitResult>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].unit, b[i].unit);
    EXPECT_EQ(a[i].scans, b[i].scans);
    EXPECT_EQ(a[i].state_after, b[i].state_after);
  }
}

TEST(BlockRunner, SaysNothingWithoutAllStates) {
  // Goal: a block runs only if each state is given or held, and else nothing of it runs. Method: a
  // ladder of five; every set of states given, on a worker that holds all, on one that holds none,
  // and on that one again with all given.
  constexpr std::uint32_t k_levels = 5;
  const ScanByScan numbers({.seed = 3, .roughness = {5}});
  const RecordingWorker knowing(numbers);
  const SecondScan second = second_scan(k_levels, 60, knowing);
  ASSERT_EQ(second.block.members.size(), k_levels);
  const base::ManualClock clock;
  const BlockRunner on_knowing(knowing, clock);
  const auto expected = on_knowing.run(second.block, second.states);
  ASSERT_EQ(expected.size(), k_levels);
  for (std::uint32_t given = 0; given < 1U << k_levels; ++given) {
    std::vector<plan::GivenState> states = second.states;
    for (std::uint32_t i = 0; i < k_levels; ++i) {
      if ((given >> i & 1U) == 0) states[i].reset();
    }
    expect_same(on_knowing.run(second.block, states), expected);
    const RecordingWorker fresh(numbers);
    const BlockRunner on_fresh(fresh, clock);
    const bool has_all = given + 1 == 1U << k_levels;
    EXPECT_EQ(on_fresh.run(second.block, states).empty(), !has_all);
    EXPECT_EQ(fresh.has_run(), has_all);
    expect_same(on_fresh.run(second.block, second.states), expected);
  }
  // A worker that holds nothing at all, and a unit alone.
  const BlockRunner forgetful(numbers, clock);
  const plan::Block alone{.members = {second.block.members.front()}, .ladder = {}};
  EXPECT_TRUE(forgetful.run(alone, std::vector<plan::GivenState>(1)).empty());
  const auto by_itself = forgetful.run(alone, std::vector{second.states.front()});
  ASSERT_EQ(by_itself.size(), 1U);
  EXPECT_EQ(by_itself.front().scans.front(), expected.front().scans.front());
}

/// Each unit takes a second.
class SlowWorker final : public plan::UnitWorker {
 public:
  SlowWorker(const plan::UnitWorker& worker, base::ManualClock& clock)
      : worker_(worker), clock_(clock) {}
  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override {
    clock_.advance(1);
    plan::UnitResult result = worker_.run(unit, state);
    result.simulations = 7;
    return result;
  }

 private:
  const plan::UnitWorker& worker_;
  base::ManualClock& clock_;
};

TEST(BlockRunner, KeepsToItsScansAndSharesTheCost) {
  // Goal: each member has a scan at least, all together no more than the limit beyond that and, if
  // nothing else ends them, no fewer; the time is shared out by scans, and simulations are counted.
  // Method: a ladder of six with every limit up to 70, smaller ones put in by hand.
  constexpr std::uint32_t k_levels = 6;
  const ScanByScan numbers({.seed = 5, .roughness = {5}});
  base::ManualClock clock;
  const SlowWorker slow(numbers, clock);
  const BlockRunner runner(slow, clock);
  SecondScan second = second_scan(k_levels, 70, numbers);
  ASSERT_EQ(second.block.members.size(), k_levels);
  second.block.ladder->end_scan = 1000;
  for (std::uint32_t limit = 1; limit <= 70; ++limit) {
    second.block.ladder->scans_max = limit;
    const double begin_s = clock.now_s();
    const auto results = runner.run(second.block, second.states);
    ASSERT_EQ(results.size(), k_levels);
    std::uint32_t scans = 0;
    for (const plan::UnitResult& result : results) {
      EXPECT_GE(result.scans.size(), 1U);
      EXPECT_DOUBLE_EQ(result.cost_s, result.unit.scans);
      EXPECT_EQ(result.simulations, 7U * result.unit.scans);
      scans += result.unit.scans;
    }
    EXPECT_EQ(scans, std::max(k_levels, limit));
    EXPECT_DOUBLE_EQ(clock.now_s() - begin_s, scans);
  }

  // Three in the middle lose a side with each scan, whatever the limit is.
  plan::LadderPart& part = *second.block.ladder;
  const std::uint32_t first = 2;
  second.block.members = {second.block.members.begin() + first, second.block.members.begin() + 5};
  second.states = {second.states.begin() + first, second.states.begin() + 5};
  part.first_level = first;
  part.inverse_temperatures = {part.inverse_temperatures.begin() + first,
                               part.inverse_temperatures.begin() + 5};
  part.proposal_scales.resize(3);
  // After scan 1 levels 3 and 4 swap and level 2 with one outside; after scan 2 that is level 4
  // with 5, and 3 waits for the one at 2.
  std::uint32_t scans = 0;
  for (const plan::UnitResult& result : runner.run(second.block, second.states))
    scans += result.unit.scans;
  EXPECT_EQ(scans, 5U);

  // At the end of the round nobody goes on.
  part.end_scan = 2;
  for (const plan::UnitResult& result : runner.run(second.block, second.states))
    EXPECT_EQ(result.unit.scans, 1U);
}

std::optional<std::uint32_t> odd_even_partner(std::uint32_t level, std::uint64_t scan,
                                              std::uint32_t levels) {
  return right_even_odd_partner(level, scan + 1, levels);
}
double always_swaps(const SwapPlace& /*place*/) {
  return 0;
}
double other_number(const SwapPlace& place) {
  return 1 - right_swap_number(place);
}
double other_seed(const SwapPlace& place) {
  SwapPlace other = place;
  ++other.seed;
  return right_swap_number(other);
}
double half_ratio(const SwapPair& pair) {
  return 0.5 * right_log_swap_ratio(pair);
}

TEST(BlockRunner, WrongSwapsAreNoticed) {
  // Goal: a runner that decides swaps otherwise than the plan can't feed it: the plan sees records
  // of other temperatures than it gave. Method: wrong partners, numbers, ratios and seeds, one at a
  // time, with results that often leave swaps to chance; and the right formulas, which pass.
  ParallelTemperingOptions options = small_ladder(6);
  options.ladder.seed = 11;
  const ScanByScan numbers({.seed = 11, .roughness = {3}});
  const auto drive = [&](const Formulas& formulas) {
    Dice dice(k_seed, 5 * k_cases);
    BlockShapes shapes;
    ParallelTempering plan(options);
    AnySession session(plan, numbers);
    session.run_blocks_by([&](const BlockRunner& runner, const auto& block, auto states) {
      const Replaced replaced(formulas);
      return runner.run(block, states);
    });
    session.run_in_blocks(dice, shapes);
    EXPECT_TRUE(plan.finished());
  };
  const char* const noticed = "check failed: .*inverse_temperature";
  drive({});
  EXPECT_DEATH(drive({.partner = odd_even_partner}), noticed);
  EXPECT_DEATH(drive({.swap_number = always_swaps}), noticed);
  EXPECT_DEATH(drive({.swap_number = other_number}), noticed);
  EXPECT_DEATH(drive({.log_swap_ratio = half_ratio}), noticed);
  EXPECT_DEATH(drive({.swap_number = other_seed}), noticed);
}

}  // namespace
}  // namespace sleight::sampling
