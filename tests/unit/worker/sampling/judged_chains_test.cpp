#include "worker/sampling/judged_chains.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "common/random/distributions.h"
#include "tests/support/property.h"
#include "tests/unit/worker/sampling/any_plan.h"

namespace sleight::sampling::judged_chains_test {

/// Chains with two values. Both values start at 0 and forget this start. "helped" rises to a mean;
/// "log_p" is normal about 0. Scans are pure functions of (seed, chain, first scan of the tour,
/// scan).
struct World {
  std::uint64_t seed = 1;
  double forgets =
      0.2;  ///< rate per scan at which chains leave their start; 0: chains never leave it
  double satisfied = 0.2;

  plan::ScanRecord record(std::uint32_t chain, std::uint64_t begin, std::uint64_t scan) const {
    random::Stream stream(
        {.seed = seed, .chain = base::ChainId{chain}, .purpose = random::Purpose::proposal}, scan);
    const auto age = static_cast<double>(scan - begin);
    const double mean = forgets == 0 ? 0 : 10 * (1 - std::exp(-forgets * age));
    const double noise = forgets == 0 || age == 0 ? 0 : random::Normal{.sd = 2}.draw(stream);
    plan::ScanRecord record;
    record.method_values = {std::round(mean + noise), random::Normal{}.draw(stream)};
    record.satisfied = stream.uniform() < satisfied;
    record.log_prior = stream.uniform();
    record.log_constraint = -2 * stream.uniform();
    record.lineage = plan::lineage_from({}, begin);
    return record;
  }
};

JudgedChainsOptions options(std::optional<std::uint64_t> scans,
                            std::optional<std::uint64_t> solutions) {
  return {.seed = 3,
          .chains = 4,
          .round_scans = 8,
          .judged = {{.name = "helped", .starts_at_one_end = true}, {.name = "log_p"}},
          .scans = scans,
          .independent_solutions = solutions};
}

struct End {
  std::uint64_t scans = 0;
  std::vector<std::uint64_t> parts{};
  std::vector<std::optional<std::uint64_t>> counted{};
  friend bool operator==(const End&, const End&) = default;
};

End end_of(const JudgedChains& plan) {
  End end{.scans = plan.scans_common()};
  for (const plan::DrawPart& part : plan.draws().parts) {
    end.parts.insert(end.parts.end(), {part.first_scan, part.count});
    end.counted.insert(end.counted.end(), part.counted.begin(), part.counted.end());
  }
  return end;
}

/// Hands units to `workers` workers until the plan is done or `results_max` results have arrived.
/// Results arrive in any order. Expects that a unit's flag `starts` is set exactly if its first
/// scan begins a tour.
void work(JudgedChains& plan, const World& world, std::size_t workers, random::Stream& stream,
          std::uint64_t results_max = UINT64_MAX) {
  std::vector<plan::Unit> out;
  for (std::uint64_t came = 0; came < results_max; ++came) {
    while (out.size() < workers) {
      const auto unit = plan.next_unit(
          static_cast<std::uint32_t>(1 + random::UniformInteger{.count = 20}.draw(stream)));
      if (!unit) break;
      EXPECT_EQ(unit->starts, unit->first_scan.value == plan::scan_of_lineage(unit->lineage));
      out.push_back(*unit);
    }
    if (out.empty()) return;
    std::swap(out[random::UniformInteger{.count = out.size()}.draw(stream)], out.back());
    const plan::Unit unit = out.back();
    out.pop_back();
    std::vector<plan::ScanRecord> records;
    for (std::uint64_t nth = 0; nth < unit.scans; ++nth) {
      records.push_back(world.record(unit.replica.chain.value, plan::scan_of_lineage(unit.lineage),
                                     unit.first_scan.value + nth));
    }
    plan.consume(unit.replica, unit.first_scan, records);
  }
}

TEST(JudgedChains, ComeToTheSameHoweverTheyAreRun) {
  // Goal: tours, draws and solutions depend only on the results. Workers, order and interruptions
  // don't matter. A run that is cut short has the same tours, draws and solutions as the whole run
  // up to the cut. Method: compare all runs with a run by one worker. Some runs use several
  // workers, some are cut, and some are replayed.
  for (const std::uint64_t i : property::cases(60)) {
    random::Stream stream({.seed = i, .purpose = random::Purpose::scene}, 0);
    const World world{.seed = i,
                      .forgets = 0.02 + 0.3 * stream.uniform(),
                      .satisfied = 0.01 + 0.3 * stream.uniform()};
    const std::uint64_t wanted = 1 + random::UniformInteger{.count = 12}.draw(stream);
    JudgedChains alone(options({}, wanted));
    work(alone, world, 1, stream);
    ASSERT_TRUE(alone.finished());
    EXPECT_GE(alone.solutions_found(), wanted);
    EXPECT_EQ(alone.draws().parts.back().first_scan + alone.draws().parts.back().count,
              alone.scans_common());

    expect_told_as_counted(alone, 1 + random::UniformInteger{.count = 50}.draw(stream),
                           [&](std::uint32_t chain, std::uint64_t scan) {
                             const plan::ScanRecord record = world.record(chain, 0, scan);
                             return record.log_prior + record.log_constraint;
                           });
    const auto rounds = alone.rounds_between(0, alone.scans_common());
    for (std::size_t nth = 0; nth < rounds.size(); ++nth)
      EXPECT_EQ(rounds[nth].round, nth + 1);
    EXPECT_EQ(rounds.front().scans, 8U);
    EXPECT_EQ(rounds.back().scans, alone.scans_common());
    EXPECT_EQ(alone.rounds_between(8, alone.scans_common()).size(), rounds.size() - 1);

    JudgedChains together(options({}, wanted));
    work(together, world, 1 + random::UniformInteger{.count = 6}.draw(stream), stream);
    EXPECT_EQ(end_of(together), end_of(alone));

    // If a limit on scans ends a run within a tour, the run keeps the draws of earlier tours.
    const std::uint64_t cut =
        1 + random::UniformInteger{.count = alone.scans_common()}.draw(stream);
    JudgedChains shorter(options(cut, {}));
    work(shorter, world, 3, stream);
    EXPECT_EQ(shorter.scans_common(), cut);
    End expected{.scans = cut};
    for (const plan::DrawPart& part : alone.draws().parts) {
      if (part.first_scan + part.count > cut) break;
      expected.parts.insert(expected.parts.end(), {part.first_scan, part.count});
      expected.counted.insert(expected.counted.end(), part.counted.begin(), part.counted.end());
    }
    EXPECT_EQ(end_of(shorter), expected);

    // Replay chain by chain, as from a run store.
    JudgedChains replayed(options({}, wanted));
    std::map<std::uint32_t, std::vector<plan::ScanRecord>> stored;
    std::vector<std::uint64_t> begins{0};
    for (const plan::DrawPart& part : alone.draws().parts)
      begins.push_back(part.first_scan + part.count);
    for (std::uint32_t chain = 0; chain < 4; ++chain) {
      for (std::uint64_t scan = 0; scan < alone.scans_common(); ++scan) {
        const std::uint64_t begin = *std::prev(std::ranges::upper_bound(begins, scan));
        stored[chain].push_back(world.record(chain, begin, scan));
      }
      replayed.consume({base::ChainId{chain}, {}}, {}, stored[chain]);
    }
    EXPECT_TRUE(replayed.finished());
    EXPECT_EQ(end_of(replayed), end_of(alone));
  }
}

TEST(JudgedChains, CountASatisfyingScanOfEachChainOfEachTour) {
  // Goal: a solution is any satisfying scan among the draws, and each chain contributes at most one
  // solution per tour. Method: run until 400 solutions are counted. Check that counted scans are at
  // many different places in their tours' draws.
  const World world{.forgets = 0.5, .satisfied = 0.3};
  JudgedChains plan(options({}, 400));
  random::Stream stream({.seed = 1, .purpose = random::Purpose::scene}, 0);
  work(plan, world, 2, stream);
  std::uint64_t solutions = 0;
  std::set<std::uint64_t> places;
  for (const plan::DrawPart& part : plan.draws().parts) {
    ASSERT_EQ(part.counted.size(), 4U);
    for (std::uint32_t chain = 0; chain < 4; ++chain) {
      const auto& counted = part.counted[chain];
      if (!counted) continue;
      ++solutions;
      EXPECT_TRUE(world.record(chain, 0, *counted).satisfied);
      ASSERT_GE(*counted, part.first_scan);
      ASSERT_LT(*counted, part.first_scan + part.count);
      places.insert(*counted - part.first_scan);
    }
  }
  EXPECT_EQ(solutions, plan.solutions_found());
  EXPECT_GE(places.size(), 10U);
}

TEST(JudgedChains, ChainsThatNeverLeaveTheirStartNeverBurnIn) {
  // Goal: chains that never leave their start don't pass the judge, even if all of them agree.
  // Method: run such chains for 4000 scans. The same chains pass if starts_at_one_end is false.
  const World stuck{.forgets = 0};
  random::Stream stream({.seed = 1, .purpose = random::Purpose::scene}, 0);
  JudgedChains plan(options(4000, {}));
  work(plan, stuck, 2, stream);
  EXPECT_TRUE(plan.finished());
  EXPECT_EQ(plan.solutions_found(), 0U);
  EXPECT_EQ(plan.draws().count, 0U);
  EXPECT_TRUE(plan.report().empty());

  JudgedChainsOptions lenient = options(4000, {});
  lenient.judged[0].starts_at_one_end = false;
  JudgedChains other(lenient);
  work(other, stuck, 2, stream);
  EXPECT_GT(other.solutions_found(), 0U);
}

TEST(JudgeValue, SeesDriftsAndChainsThatDisagree) {
  // Goal: judge_value() rejects chains that haven't forgotten their start. Method: judge sets of 8
  // chains of 200 draws. In one set, all chains have the same distribution. In one set, all chains
  // drift. In one set, the chains' means differ. In some sets, chains are constant.
  random::Stream stream({.seed = 2, .purpose = random::Purpose::scene}, 0);
  std::vector<double> starts{0};
  const auto judged = [&](auto&& value, bool starts_at_one_end = true) {
    OwnedChains draws{.values = {}, .chains = 8, .draws = 200};
    for (std::size_t chain = 0; chain < draws.chains; ++chain)
      for (std::size_t draw = 0; draw < draws.draws; ++draw)
        draws.values.push_back(value(chain, static_cast<double>(draw)));
    return judge_value({.name = "x", .starts_at_one_end = starts_at_one_end}, starts, draws.view());
  };
  const auto normal = [&] { return random::Normal{}.draw(stream); };
  EXPECT_TRUE(judged([&](std::size_t, double) { return normal(); }).passes);
  EXPECT_FALSE(judged([&](std::size_t, double draw) { return normal() + 0.02 * draw; }).passes);
  EXPECT_FALSE(judged([&](std::size_t chain, double) {
                 return normal() + 0.5 * static_cast<double>(chain);
               }).passes);
  EXPECT_FALSE(judged([](std::size_t, double) { return 0.0; }).passes);
  EXPECT_TRUE(judged([](std::size_t, double) { return 0.0; }, false).passes);
  EXPECT_FALSE(
      judged([](std::size_t chain, double) { return static_cast<double>(chain); }, false).passes);
  // If the values are only 0 and 1 and chains start at both, no chain ever leaves the starts.
  const auto bit = [&](std::size_t, double) { return normal() > 0 ? 1.0 : 0.0; };
  EXPECT_TRUE(judged(bit).passes);
  starts = {0, 1};
  EXPECT_FALSE(judged(bit).passes);
}

}  // namespace sleight::sampling::judged_chains_test
