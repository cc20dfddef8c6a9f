// Compares parallel tempering with a reference, bit for bit. The reference runs all replicas in
// lockstep; the tested plans run units or blocks.
#include "worker/sampling/block_runner.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <map>
#include <optional>
#include <set>

#include "tests/support/property.h"
#include "tests/tempering/slow_ladder.h"
#include "tests/unit/worker/sampling/any_plan.h"
#include "tests/unit/worker/sampling/replaced_formulas.h"
#include "tests/unit/worker/sampling/scans_of.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"

namespace sleight::sampling::block_runner_test {

constexpr std::uint64_t k_seed = 424243;
constexpr std::uint64_t k_cases = 120;
constexpr std::uint64_t k_scans_max = 260;
std::uint64_t cases() {
  return property::of_tier(40, k_cases);
}
/// Scans in which the reference looks for the stop.
constexpr std::uint64_t k_longest = 2 * k_scans_max;

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
  made.options.ladder.starts_by_search = dice.once_in(3);
  if (made.options.ladder.starts_by_search) made.options.ladder.anneal_scans = 0;
  StopRule& stop = made.options.stop;
  if (dice.once_in(2)) stop.independent_solutions = 1 + dice.below(40);
  if (dice.once_in(2)) stop.rounds = static_cast<std::uint32_t>(1 + dice.below(3));
  if (dice.once_in(2) || !stop.rounds) stop.scans = 1 + dice.below(k_scans_max);
  return made;
}

std::uint64_t end_of_round(const Case& given, std::uint32_t round) {
  const LadderOptions& ladder = given.options.ladder;
  return ladder.anneal_scans + scans_through_round(ladder.round_scans, round);
}

/// Returns the end of the first burnt-in round: in its last scan, no state descends from a search's
/// find. Empty if no such round ends within `scans`.
std::optional<std::uint64_t> burnt_in_at(const Case& given, const std::vector<SlowLadder>& all,
                                         std::uint64_t scans) {
  if (!given.options.ladder.starts_by_search) return given.options.ladder.anneal_scans;
  for (std::uint32_t round = 1; end_of_round(given, round) <= scans; ++round) {
    const std::uint64_t end = end_of_round(given, round);
    const auto descends = [&](const auto& run) {
      const auto& [place, result] = run;
      const std::uint64_t lineage = result.scans.front().lineage;
      // The hottest replica's first state is a draw from the prior.
      return place.second + 1 == end && lineage != plan::lineage_from(base::ReplicaId{0}, 0) &&
             plan::scan_of_lineage(lineage) == 0;
    };
    if (std::ranges::none_of(all, [&](const SlowLadder& ladder) {
          return std::ranges::any_of(ladder.results, descends);
        }))
      return end;
  }
  return std::nullopt;
}

/// Counts the lineages that have a satisfying scan s at inverse temperature 1. Ignores scans
/// outside first <= s < end.
std::uint64_t solutions_between(const SlowLadder& ladder, std::uint64_t first, std::uint64_t end) {
  std::set<std::uint64_t> lineages;
  for (const auto& [place, result] : ladder.results) {
    const plan::ScanRecord& record = result.scans.front();
    if (place.second >= first && place.second < end && record.satisfied &&
        record.inverse_temperature == 1)
      lineages.insert(record.lineage);
  }
  return lineages.size();
}

/// Applies the stop rules to all results. Returns the scan at which the run must stop.
std::uint64_t stop_of(const Case& given, const std::vector<SlowLadder>& all) {
  const StopRule& stop = given.options.stop;
  const auto burnt_in = burnt_in_at(given, all, k_longest);
  for (std::uint32_t round = 1;; ++round) {
    const std::uint64_t round_end = end_of_round(given, round);
    if (stop.scans && *stop.scans <= round_end) return *stop.scans;
    if (stop.rounds && *stop.rounds == round) return round_end;
    std::uint64_t solutions = 0;
    for (const SlowLadder& ladder : all)
      solutions += burnt_in ? solutions_between(ladder, *burnt_in, round_end) : 0;
    if (stop.independent_solutions && solutions >= *stop.independent_solutions) return round_end;
  }
}

struct Expected {
  std::uint64_t end = 0;
  std::optional<std::uint64_t> burnt_in{};
  std::uint64_t solutions = 0;
  ScanRuns runs;
  std::vector<SlowLadder> ladders;
};

Expected expected_of(const Case& given) {
  const auto all = [&](std::uint64_t scans) {
    std::vector<SlowLadder> ladders;
    LadderOptions options = given.options.ladder;
    for (std::uint32_t chain = 0; chain < given.options.ladders; ++chain) {
      options.chain = base::ChainId{chain};
      ladders.push_back(slow_ladder(options, given.worker, scans));
    }
    return ladders;
  };
  Expected run{.end = stop_of(given, all(k_longest)), .runs = {}, .ladders = {}};
  run.ladders = all(run.end);
  run.burnt_in = burnt_in_at(given, run.ladders, run.end);
  for (const SlowLadder& ladder : run.ladders) {
    run.solutions += run.burnt_in ? solutions_between(ladder, *run.burnt_in, run.end) : 0;
    for (const auto& [place, result] : ladder.results) {
      const plan::Unit unit = alone(result.unit, 0, result.unit.lineage);
      run.runs[{unit.replica, place.second}] = {unit, result.scans.front(), result.state_after};
    }
  }
  return run;
}

/// Expects that the reported rounds are the rounds after the burn-in.
void expect_rounds_after(const plan::Report& report, const std::vector<SlowLadder>& expected,
                         std::uint64_t burnt_in) {
  std::size_t rounds = 0;
  std::vector<std::vector<double>> log_z;  // by ladder, by round
  for (const SlowLadder& ladder : expected) {
    std::vector<double>& of_ladder = log_z.emplace_back();
    for (const RoundReport& round : ladder.rounds) {
      if (round.first_scan >= burnt_in && round.statistics.scans() > 0)
        of_ladder.push_back(round.statistics.log_z().value);
    }
    rounds = std::max(rounds, of_ladder.size());
  }
  const auto table = std::ranges::find(report.tables, "log_z", &plan::Table::name);
  ASSERT_EQ(table != report.tables.end(), rounds > 0);
  if (rounds == 0) return;
  ASSERT_EQ(table->dims[1].second, rounds);
  for (std::size_t l = 0; l < expected.size(); ++l) {
    for (std::size_t r = 0; r < log_z[l].size(); ++r)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(table->values[l * rounds + r]),
                std::bit_cast<std::uint64_t>(log_z[l][r]));
  }
}

void expect_end(const ParallelTempering& plan, const AnySession& session,
                const Expected& expected) {
  EXPECT_TRUE(plan.finished());
  EXPECT_EQ(plan.scans_common(), expected.end);
  EXPECT_EQ(plan.scans_consumed(), expected.runs.size());
  EXPECT_EQ(plan.scans_total(), expected.runs.size());
  EXPECT_EQ(plan.solutions_found(), expected.solutions);
  EXPECT_EQ(plan.draws().first_scan, expected.burnt_in.value_or(expected.end));
  EXPECT_TRUE(session.runs() == expected.runs);
  for (std::size_t i = 0; i < expected.ladders.size(); ++i) {
    const LadderRun& ladder = plan.ladders()[i];
    const SlowLadder& slow = expected.ladders[i];
    EXPECT_EQ(fingerprint(ladder.rounds(), scans_of(ladder.solutions())),
              fingerprint(slow.rounds, slow.solutions));
  }
  expect_rounds_after(plan.report(), expected.ladders, expected.burnt_in.value_or(expected.end));
}

struct LadderShapes {
  std::uint64_t burn_ins = 0;
  std::uint64_t grew = 0;
  std::uint64_t shrank = 0;
  std::uint64_t trips = 0;

  void add(const Expected& expected, bool starts_by_search) {
    burn_ins += starts_by_search && expected.burnt_in ? 1 : 0;
    for (const SlowLadder& ladder : expected.ladders) {
      for (std::size_t r = 0; r < ladder.rounds.size(); ++r) {
        trips += ladder.rounds[r].round_trips;
        if (r == 0) continue;
        const std::size_t before = ladder.rounds[r - 1].counts.size();
        grew += ladder.rounds[r].counts.size() > before ? 1 : 0;
        shrank += ladder.rounds[r].counts.size() < before ? 1 : 0;
      }
    }
  }
};

TEST(BlockRunner, EqualsTheLockstepReference) {
  // Goal: whether replicas run in units or in blocks, the run equals the reference in units,
  // records, states, rounds, solutions and stop. Workers, cuts of units and the order of results
  // don't matter. Method: run each random case in three random sessions. Some cases start with a
  // search. At the end, check that ladders grew and shrank, and that all shapes of blocks occurred
  // often.
  BlockShapes shapes;
  LadderShapes ladders;
  for (const std::uint64_t index : property::cases(cases())) {
    Dice dice(k_seed, index);
    const Case given = random_case(dice);
    const Expected expected = expected_of(given);
    ladders.add(expected, given.options.ladder.starts_by_search);
    for (int repeat = 0; repeat < 3; ++repeat) {
      ParallelTempering plan(given.options);
      AnySession session(plan, given.worker);
      if (repeat == 0) {
        session.run_randomly(dice);
      } else {
        session.run_in_blocks(dice, shapes);
      }
      expect_end(plan, session, expected);
      EXPECT_EQ(plan.next_block({.unit_scans_max = 1, .block_scans_max = 1}), std::nullopt);
      if (HasFailure()) return;
    }
  }
  if (!property::all_cases() || cases() < k_cases) return;
  EXPECT_GE(ladders.burn_ins, 5U);
  EXPECT_GE(ladders.grew, 5U);
  EXPECT_GE(ladders.shrank, 5U);
  EXPECT_GT(ladders.trips, 1000U);
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

ParallelTemperingOptions small_ladder(std::uint32_t levels) {
  ParallelTemperingOptions options;
  options.ladder.first_ladder = first_ladder(levels);
  options.ladder.round_scans = 1000;
  options.stop.scans = 1000;
  return options;
}

/// The block that a whole ladder runs after its first scan, and the states before that block.
struct SecondScan {
  plan::Block block;
  std::vector<plan::GivenState> states;
};

SecondScan second_scan(std::uint32_t levels, std::uint32_t scans_max,
                       const plan::UnitWorker& worker) {
  ParallelTempering plan(small_ladder(levels));
  std::map<plan::ReplicaKey, base::Bytes> states;
  // Request all units before consuming any result, so that each unit is a replica's first scan.
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
  // Goal: in a block, each member runs at least one scan, and all members together run as many
  // scans as the limit allows. The runner shares the block's cost equally among the scans, and
  // counts the simulations. Method: run a ladder of six levels with every limit up to 70. Then run
  // only three middle levels. The middle levels' block ends earlier, because swap partners are
  // outside the block.
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

  // Three middle levels run five scans: all three levels run scan 1, and two levels run scan 2.
  plan::LadderPart& part = *second.block.ladder;
  const std::uint32_t first = 2;
  second.block.members = {second.block.members.begin() + first, second.block.members.begin() + 5};
  second.states = {second.states.begin() + first, second.states.begin() + 5};
  part.first_level = first;
  part.inverse_temperatures = {part.inverse_temperatures.begin() + first,
                               part.inverse_temperatures.begin() + 5};
  part.proposal_scales.resize(3);
  // After scan 1, levels 3 and 4 swap and level 2's partner is outside. After scan 2, level 4's
  // partner 5 is outside, and level 3 waits for level 2.
  std::uint32_t scans = 0;
  for (const plan::UnitResult& result : runner.run(second.block, second.states))
    scans += result.unit.scans;
  EXPECT_EQ(scans, 5U);

  // No member continues beyond the end of the round.
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
  // Goal: if a runner decides swaps differently, the plan rejects the results, because the reported
  // temperatures differ from the plan's temperatures. Method: the swap has formulas for the
  // partner, the random number, the ratio and the seed. Replace one formula at a time by a wrong
  // formula. With the right formulas, the plan accepts all results.
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

}  // namespace sleight::sampling::block_runner_test
