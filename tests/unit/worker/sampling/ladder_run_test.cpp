// Parallel tempering against a plain lockstep reference, bit for bit, however results arrive.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <map>
#include <set>

#include "common/random/discrete_distributions.h"
#include "tests/support/property.h"
#include "tests/unit/worker/sampling/slow_ladder.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_seed = 137035;
constexpr std::uint64_t k_cases = 60;
constexpr std::uint64_t k_scans_max = 260;

class Dice {
 public:
  explicit Dice(std::uint64_t index)
      : stream_({.seed = k_seed, .purpose = random::Purpose::prior}, index) {}
  std::uint64_t below(std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream_);
  }
  bool once_in(std::uint64_t count) { return below(count) == 0; }

 private:
  random::Stream stream_;
};

struct Case {
  ParallelTemperingOptions options;
  HashedWorker worker;
};

Case random_case(Dice& dice) {
  const std::uint64_t seed = dice.below(1000);
  Case made{.options = {},
            .worker = HashedWorker({.seed = seed,
                                    .roughness = {0.1, 2, 12, 60},
                                    .broken = dice.once_in(2) ? 0 : 0.2,
                                    .satisfied = dice.once_in(2) ? 0.02 : 0.3})};
  made.options.ladders = static_cast<std::uint32_t>(1 + dice.below(3));
  made.options.ladder = {
      .seed = seed,
      .chain = {},
      .first_ladder = first_ladder(static_cast<std::uint32_t>(2 + dice.below(7))),
      .levels_chosen = !dice.once_in(3),
      .levels_max = static_cast<std::uint32_t>(4 + dice.below(12)),
      .ladder_adapts = !dice.once_in(3),
      .has_scale = dice.once_in(3) ? std::vector<bool>{} : std::vector<bool>{true, dice.once_in(2)},
      .round_scans = 1 + dice.below(40)};
  StopRule& stop = made.options.stop;
  if (dice.once_in(2)) stop.independent_solutions = 1 + dice.below(40);
  if (dice.once_in(2)) stop.rounds = static_cast<std::uint32_t>(1 + dice.below(3));
  if (dice.once_in(2) || !stop.rounds) stop.scans = 1 + dice.below(k_scans_max);
  made.options.ladder.starts_by_search = dice.once_in(3);
  return made;
}

LadderOptions ladder_options(const Case& given, std::uint32_t chain) {
  LadderOptions options = given.options.ladder;
  options.chain = base::ChainId{chain};
  return options;
}

/// The reference of all ladders.
std::vector<SlowLadder> slow_ladders(const Case& given, std::uint64_t scans) {
  std::vector<SlowLadder> ladders;
  for (std::uint32_t chain = 0; chain < given.options.ladders; ++chain)
    ladders.push_back(slow_ladder(ladder_options(given, chain), given.worker, scans));
  return ladders;
}

std::uint64_t end_of_round(const Case& given, std::uint32_t round) {
  return given.options.ladder.round_scans * ((std::uint64_t{1} << round) - 1);
}

/// The end of the first round whose last scan has no state that descends from a search's find; none
/// among so many scans.
std::optional<std::uint64_t> burnt_in_at(const Case& given, const std::vector<SlowLadder>& all,
                                         std::uint64_t scans) {
  if (!given.options.ladder.starts_by_search) return 0;
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

/// Lineages that satisfied at inverse temperature 1 within these scans.
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

/// Where the run must stop, from all results, by the rules as they are written.
std::uint64_t scans_at_stop(const Case& given) {
  const StopRule& stop = given.options.stop;
  const std::vector<SlowLadder> all = slow_ladders(given, k_scans_max);
  const auto burnt_in = burnt_in_at(given, all, k_scans_max);
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

/// What a run store would hold.
using Stored = std::map<plan::ReplicaKey, std::vector<plan::UnitResult>>;

/// Drives a plan with units that complete in random order, and checks each against the reference.
class Session {
 public:
  Session(const Case& given, const std::vector<SlowLadder>& expected, Dice& dice)
      : given_(given), expected_(expected), dice_(dice), plan_(given.options) {}

  ParallelTempering& plan() { return plan_; }
  const Stored& stored() const { return stored_; }

  void run(std::uint64_t steps = std::numeric_limits<std::uint64_t>::max()) {
    // Some sessions keep much in flight, some little.
    const std::uint64_t odds = 1 + dice_.below(6);
    for (; steps > 0 && !plan_.finished(); --steps) {
      if (running_.empty() || !dice_.once_in(odds)) {
        hand_out();
      } else {
        complete_one();
      }
      if (::testing::Test::HasFailure()) return;
    }
  }
  void complete_all() {
    while (!running_.empty())
      complete_one();
  }

  /// Takes in what an earlier session stored: whole replicas, in random order and batches.
  void replay(const Stored& stored, bool in_order) {
    std::vector<plan::ReplicaKey> keys;
    for (const auto& [key, results] : stored)
      keys.push_back(key);
    for (std::size_t i = keys.size(); !in_order && i > 1; --i)
      std::swap(keys[i - 1], keys[dice_.below(i)]);
    for (const plan::ReplicaKey& key : keys) {
      const std::vector<plan::UnitResult>& results = stored.at(key);
      for (std::size_t i = 0; i < results.size();) {
        const std::size_t count = std::min(results.size() - i, 1 + dice_.below(30));
        std::vector<plan::ScanRecord> batch;
        for (std::size_t k = 0; k < count; ++k)
          batch.push_back(results[i + k].scans.front());
        plan_.consume(key, results[i].unit.first_scan, batch);
        i += count;
      }
    }
    stored_ = stored;
  }

  /// All units of the reference and no others were run.
  void expect_all_ran() const {
    std::size_t count = 0;
    for (const SlowLadder& ladder : expected_)
      count += ladder.units.size();
    std::size_t ran = 0;
    for (const auto& [key, results] : stored_)
      ran += results.size();
    EXPECT_EQ(ran, count);
  }

 private:
  void hand_out() {
    const std::optional<plan::Unit> unit = plan_.next_unit(1);
    if (!unit) {
      ASSERT_FALSE(running_.empty()) << "nothing runs, nothing is handed out, not finished";
      complete_one();
      return;
    }
    ASSERT_LT(unit->replica.chain.value, expected_.size());
    const auto& units = expected_[unit->replica.chain.value].units;
    const auto found = units.find({unit->replica.replica.value, unit->first_scan.value});
    ASSERT_NE(found, units.end()) << "a unit that the reference doesn't have";
    ASSERT_EQ(*unit, found->second);
    const std::vector<plan::UnitResult>& before = stored_[unit->replica];
    const base::Bytes none;
    running_.push_back(given_.worker.run(*unit, before.empty() ? none : before.back().state_after));
  }

  void complete_one() {
    const std::size_t which = dice_.below(running_.size());
    const plan::UnitResult result = running_[which];
    running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(which));
    plan_.consume(result.unit.replica, result.unit.first_scan, result.scans);
    stored_[result.unit.replica].push_back(result);
  }

  const Case& given_;
  const std::vector<SlowLadder>& expected_;
  Dice& dice_;
  ParallelTempering plan_;
  Stored stored_;
  std::vector<plan::UnitResult> running_;
};

/// The rounds that are told are those after the burn-in.
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

/// Which level each replica is at is what the temperatures of the reference's units say.
void expect_index_process(const LadderRun& ladder, const SlowLadder& expected,
                          std::uint64_t first_scan, std::uint64_t end) {
  std::map<std::uint64_t, std::map<std::uint32_t, double>> betas;  // by scan, by replica
  for (const auto& [place, unit] : expected.units)
    betas[place.second][place.first] = unit.inverse_temperatures.front();
  std::uint64_t stride = 1;
  while ((end + stride - 1) / stride - (first_scan + stride - 1) / stride >
         IndexProcess::k_moments_max)
    stride *= 2;
  std::uint64_t scan = (first_scan + stride - 1) / stride * stride;
  for (const IndexProcess::Moment& moment : ladder.index_process().moments()) {
    ASSERT_EQ(moment.scan, scan);
    const std::map<std::uint32_t, double>& at = betas.at(scan);
    ASSERT_LT(at.rbegin()->first, moment.level.size());
    for (std::uint32_t replica = 0; replica < moment.level.size(); ++replica) {
      const auto there = at.find(replica);
      std::uint16_t level = IndexProcess::k_no_level;
      if (there != at.end()) {
        level = static_cast<std::uint16_t>(std::ranges::count_if(
            at, [&](const auto& other) { return other.second < there->second; }));
      }
      ASSERT_EQ(moment.level[replica], level);
    }
    scan += stride;
  }
  EXPECT_GE(scan, end);
}

void expect_end(const Case& given, Session& session, const std::vector<SlowLadder>& expected,
                std::uint64_t end) {
  ParallelTempering& plan = session.plan();
  EXPECT_TRUE(plan.finished());
  EXPECT_EQ(plan.scans_common(), end);
  EXPECT_EQ(plan.next_unit(1), std::nullopt);
  session.expect_all_ran();
  const auto burnt_in = burnt_in_at(given, expected, end);
  std::uint64_t solutions = 0;
  std::uint64_t scans = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const LadderRun& ladder = plan.ladders()[i];
    EXPECT_EQ(ladder.scans(), end);
    EXPECT_EQ(ladder.solutions().scans(), expected[i].solutions);
    expect_index_process(ladder, expected[i], given.options.ladder.anneal_scans, end);
    EXPECT_EQ(fingerprint(ladder.rounds(), ladder.solutions().scans()),
              fingerprint(expected[i].rounds, expected[i].solutions));
    solutions += burnt_in ? solutions_between(expected[i], *burnt_in, end) : 0;
    scans += expected[i].units.size();
  }
  EXPECT_EQ(plan.draws().first_scan, burnt_in.value_or(end));
  EXPECT_EQ(plan.draws().count, end - std::min(end, burnt_in.value_or(end)));
  expect_rounds_after(plan.report(), expected, burnt_in.value_or(end));
  EXPECT_EQ(plan.solutions_found(), solutions);
  EXPECT_EQ(plan.scans_consumed(), scans);
  EXPECT_EQ(plan.scans_total(), scans);
}

/// Bit for bit, NaN included.
void expect_equal(const plan::Report& a, const plan::Report& b) {
  ASSERT_EQ(a.tables.size(), b.tables.size());
  for (std::size_t t = 0; t < a.tables.size(); ++t) {
    EXPECT_EQ(a.tables[t].dims, b.tables[t].dims);
    ASSERT_EQ(a.tables[t].values.size(), b.tables[t].values.size());
    for (std::size_t i = 0; i < a.tables[t].values.size(); ++i) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(a.tables[t].values[i]),
                std::bit_cast<std::uint64_t>(b.tables[t].values[i]))
          << a.tables[t].name;
    }
  }
}

TEST(LadderRun, EqualsTheLockstepReference) {
  // Goal: units, rounds, solutions, statistics and the stop are those of the reference, whatever
  // the order in which units complete. Method: random cases with ladders that grow and shrink,
  // results that remember all that units said, several random sessions of each.
  std::set<std::size_t> level_counts;
  std::uint64_t burn_ins = 0;
  bool grew = false;
  bool shrank = false;
  std::uint64_t trips = 0;
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(index);
    const Case given = random_case(dice);
    const std::uint64_t end = scans_at_stop(given);
    const std::vector<SlowLadder> expected = slow_ladders(given, end);
    for (int repeat = 0; repeat < 3; ++repeat) {
      Session session(given, expected, dice);
      session.run();
      expect_end(given, session, expected, end);
      if (HasFailure()) return;
    }
    burn_ins += burnt_in_at(given, expected, end).value_or(0) > 0 ? 1 : 0;
    for (const SlowLadder& ladder : expected) {
      for (std::size_t r = 0; r < ladder.rounds.size(); ++r) {
        const std::size_t levels = ladder.rounds[r].counts.size();
        level_counts.insert(levels);
        trips += ladder.rounds[r].round_trips;
        if (r == 0) continue;
        grew = grew || levels > ladder.rounds[r - 1].counts.size();
        shrank = shrank || levels < ladder.rounds[r - 1].counts.size();
      }
    }
  }
  if (!property::all_cases()) return;
  // The cases have in them what the test is for.
  EXPECT_GE(burn_ins, 5U);
  EXPECT_TRUE(grew);
  EXPECT_TRUE(shrank);
  EXPECT_GE(level_counts.size(), 6U);
  EXPECT_GT(trips, 1000U);
}

TEST(LadderRun, GoesOnFromAnyStoredResults) {
  // Goal: a fresh plan that consumes stored results replica by replica is where the stopped one is,
  // and both end like the reference. Method: stop at a random moment, with what was in flight lost
  // or kept; replay in the store's order or another.
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(k_cases + index);
    const Case given = random_case(dice);
    const std::uint64_t end = scans_at_stop(given);
    const std::vector<SlowLadder> expected = slow_ladders(given, end);
    Session stopped(given, expected, dice);
    stopped.run(dice.below(3000));
    if (dice.once_in(2)) stopped.complete_all();
    Session resumed(given, expected, dice);
    resumed.replay(stopped.stored(), dice.once_in(2));
    EXPECT_EQ(resumed.plan().finished(), stopped.plan().finished());
    EXPECT_EQ(resumed.plan().scans_common(), stopped.plan().scans_common());
    EXPECT_EQ(resumed.plan().scans_consumed(), stopped.plan().scans_consumed());
    EXPECT_EQ(resumed.plan().scans_total(), stopped.plan().scans_total());
    EXPECT_EQ(resumed.plan().solutions_found(), stopped.plan().solutions_found());
    expect_equal(resumed.plan().report(), stopped.plan().report());
    resumed.run();
    expect_end(given, resumed, expected, end);
    if (HasFailure()) return;
  }
}

TEST(LadderRun, CutAtAnyScanIsTheRunOfThatManyScans) {
  // Goal: of a run cut at scan N, a plan that is fed the stored scans below N learns what the run
  // asked for N scans learns. Method: whole runs; every replica's results cut at a random N.
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(2 * k_cases + index);
    const Case given = random_case(dice);
    const std::uint64_t end = scans_at_stop(given);
    const std::vector<SlowLadder> expected = slow_ladders(given, end);
    Session whole(given, expected, dice);
    whole.run();
    const std::uint64_t cut = 1 + dice.below(end);
    Stored kept;
    for (const auto& [key, results] : whole.stored()) {
      for (const plan::UnitResult& result : results) {
        if (result.unit.first_scan.value < cut) kept[key].push_back(result);
      }
    }
    Case shorter = given;
    shorter.options.stop = {.scans = cut, .rounds = {}, .independent_solutions = {}};
    const std::vector<SlowLadder> expected_shorter = slow_ladders(shorter, cut);
    Session learner(shorter, expected_shorter, dice);
    learner.replay(kept, true);
    expect_end(shorter, learner, expected_shorter, cut);
    Session direct(shorter, expected_shorter, dice);
    direct.run();
    expect_equal(learner.plan().report(), direct.plan().report());
    if (HasFailure()) return;
  }
}

TEST(LadderRun, KnowsHowMuchThereIsToDo) {
  // Goal: the total is told beforehand and stays, though replicas run ahead of one another. Method:
  // two ladders of four fixed levels; asked at every step.
  Dice dice(3 * k_cases);
  Case given = random_case(dice);
  given.options.ladders = 2;
  given.options.ladder.first_ladder = first_ladder(4);
  given.options.ladder.levels_chosen = false;
  given.options.stop = {.scans = 50, .rounds = {}, .independent_solutions = {}};
  const std::vector<SlowLadder> expected = slow_ladders(given, 50);
  Session session(given, expected, dice);
  while (!session.plan().finished() && !HasFailure()) {
    ASSERT_EQ(session.plan().scans_total(), 2U * 4 * 50);
    session.run(1);
  }
  expect_end(given, session, expected, 50);
}

}  // namespace
}  // namespace sleight::sampling
