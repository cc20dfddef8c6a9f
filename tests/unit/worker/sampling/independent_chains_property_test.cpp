// Compares the stop of independent chains with a reference that knows all results in advance.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "tests/support/property.h"
#include "worker/sampling/independent_chains.h"
#include "worker/sampling/island_estimate.h"

namespace sleight::sampling::independent_chains_property_test {

constexpr std::uint64_t k_seed = 271828;
constexpr std::uint64_t k_cases = 400;
/// Every run ends before this scan, because each case has a rule that ensures this.
constexpr std::uint64_t k_scans_max = 400;

struct Case {
  IndependentChainsOptions options;
  std::uint64_t islands_of_scan = 1;
  std::vector<std::vector<plan::ScanRecord>> results;  ///< by chain, then scan
};

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

std::vector<double> some_islands(std::uint64_t count) {
  std::vector<double> values;
  for (; count > 0; --count)
    IslandEstimate{.log_z = -1, .log_satisfied = -200}.append_to(values);
  return values;
}

Case random_case(Dice& dice) {
  Case made;
  made.options.chains = static_cast<std::uint32_t>(1 + dice.below(6));
  made.options.round_scans = 1 + dice.below(20);
  StopRule& stop = made.options.stop;
  if (dice.once_in(2)) stop.independent_solutions = 1 + dice.below(12);
  if (dice.once_in(2)) stop.rounds = static_cast<std::uint32_t>(1 + dice.below(4));
  if (dice.once_in(2) || !stop.rounds) stop.scans = 1 + dice.below(k_scans_max);
  made.options.has_islands = dice.once_in(2);
  made.islands_of_scan = 1 + dice.below(3);
  const std::uint64_t rarity = 1 + dice.below(60);
  for (std::uint32_t chain = 0; chain < made.options.chains; ++chain) {
    std::uint64_t lineage = 0;
    std::vector<plan::ScanRecord>& scans = made.results.emplace_back(k_scans_max);
    for (plan::ScanRecord& scan : scans) {
      if (dice.once_in(20)) lineage += 1 + dice.below(3);
      scan.lineage = lineage;
      scan.satisfied = dice.once_in(rarity);
      if (made.options.has_islands) scan.method_values = some_islands(made.islands_of_scan);
    }
  }
  return made;
}

bool has_enough_solutions(const Case& given, std::uint64_t scans) {
  std::set<std::pair<std::size_t, std::uint64_t>> solved;
  for (std::size_t chain = 0; chain < given.results.size(); ++chain) {
    for (std::uint64_t scan = 0; scan < scans; ++scan) {
      const plan::ScanRecord& record = given.results[chain].at(scan);
      if (record.satisfied) solved.emplace(chain, record.lineage);
    }
  }
  const auto& wanted = given.options.stop.independent_solutions;
  return wanted && solved.size() >= *wanted;
}

/// Reference: applies the stop rules to all results. Returns the scan at which the run must stop.
std::uint64_t end_of(const Case& given) {
  const StopRule& stop = given.options.stop;
  std::uint64_t round_end = 0;
  std::uint64_t round_length = given.options.round_scans;
  for (std::uint32_t round = 1;; ++round) {
    round_end += round_length;
    round_length *= 2;
    if (stop.scans && *stop.scans < round_end) return *stop.scans;
    const bool is_last = stop.scans == round_end || stop.rounds == round;
    if (is_last || has_enough_solutions(given, round_end)) return round_end;
  }
}

/// Drives a plan with units of random sizes that complete in random order, and checks each unit.
class Session {
 public:
  Session(const Case& given, Dice& dice)
      : given_(given), dice_(dice), plan_(given.options), consumed_(given.options.chains, 0) {}

  IndependentChains& plan() { return plan_; }

  /// Consumes an earlier session's stored results of a chain, in batches.
  void replay(std::uint32_t chain, std::uint64_t scans) {
    while (consumed_[chain] < scans)
      consume(chain, std::min(scans - consumed_[chain], 1 + dice_.below(50)));
  }

  void run() {
    while (!plan_.finished()) {
      if (!dice_.once_in(3) || running_.empty()) {
        hand_out();
      } else {
        complete_one();
      }
      if (::testing::Test::HasFailure()) return;
    }
  }
  const std::vector<std::uint64_t>& consumed() const { return consumed_; }

 private:
  void hand_out() {
    const std::uint32_t most = static_cast<std::uint32_t>(1 + dice_.below(40));
    const std::optional<plan::Unit> unit = plan_.next_unit(most);
    if (!unit) {
      ASSERT_FALSE(running_.empty()) << "nothing runs, nothing is handed out, not finished";
      return;
    }
    // Check that the unit is within bounds and continues its chain, and that no idle chain is
    // further behind.
    const std::uint32_t chain = unit->replica.chain.value;
    ASSERT_LT(chain, consumed_.size());
    ASSERT_EQ(unit->first_scan.value, consumed_[chain]);
    ASSERT_GE(unit->scans, 1U);
    ASSERT_LE(unit->scans, most);
    for (std::uint32_t other = 0; other < consumed_.size(); ++other) {
      if (is_running(other)) {
        ASSERT_NE(other, chain);
        continue;
      }
      ASSERT_LE(std::pair(consumed_[chain], chain), std::pair(consumed_[other], other));
    }
    running_.push_back(*unit);
  }

  void complete_one() {
    const std::size_t which = dice_.below(running_.size());
    const plan::Unit unit = running_[which];
    running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(which));
    consume(unit.replica.chain.value, unit.scans);
  }

  void consume(std::uint32_t chain, std::uint64_t scans) {
    const std::uint64_t first = consumed_[chain];
    ASSERT_LE(first + scans, k_scans_max) << "beyond every rule's end";
    plan_.consume({base::ChainId{chain}, base::ReplicaId{0}}, base::ScanIndex{first},
                  std::span(given_.results[chain]).subspan(first, scans));
    consumed_[chain] += scans;
  }

  bool is_running(std::uint32_t chain) const {
    return std::any_of(running_.begin(), running_.end(),
                       [&](const plan::Unit& unit) { return unit.replica.chain.value == chain; });
  }

  const Case& given_;
  Dice& dice_;
  IndependentChains plan_;
  std::vector<std::uint64_t> consumed_;
  std::vector<plan::Unit> running_;
};

/// Number of islands per chain that the archive's odds count. Nothing if it isn't reported.
std::optional<double> odds_until_island(const plan::Report& report, std::uint32_t chains) {
  for (const plan::Table& table : report.tables) {
    if (table.name != "odds_until_island") continue;
    EXPECT_EQ(table.values, std::vector<double>(chains, table.values.at(0)));
    return table.values.at(0);
  }
  return std::nullopt;
}

/// Expects that the session ended at scan `end`. If solutions can end a run, the islands of a
/// complete first round yield the odds.
void expect_end(Session& session, const Case& given, std::uint64_t end) {
  EXPECT_TRUE(session.plan().finished());
  EXPECT_EQ(session.plan().scans_common(), end);
  EXPECT_EQ(session.plan().scans_consumed(), end * given.options.chains);
  EXPECT_EQ(session.plan().scans_total(), end * given.options.chains);
  EXPECT_EQ(session.plan().next_unit(1), std::nullopt);
  const StopRule& stop = given.options.stop;
  const std::uint64_t in_any_case =
      std::min(given.options.round_scans, stop.scans.value_or(k_scans_max));
  std::optional<double> until;
  if (given.options.has_islands && stop.independent_solutions && end >= in_any_case)
    until = static_cast<double>(in_any_case * given.islands_of_scan);
  EXPECT_EQ(odds_until_island(session.plan().report(), given.options.chains), until);
}

TEST(IndependentChainsProperty, StopsWhereTheResultsSay) {
  // Goal: only the results determine where a run stops. The cuts of units and the order of
  // completion don't. The run computes nothing beyond the stop. Method: draw random results and
  // stop rules. For each draw, run four random sessions, and compare their stops with the
  // reference.
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(index);
    const Case given = random_case(dice);
    const std::uint64_t end = end_of(given);
    for (int repeat = 0; repeat < 4; ++repeat) {
      Session session(given, dice);
      session.run();
      expect_end(session, given, end);
      for (const std::uint64_t consumed : session.consumed())
        EXPECT_EQ(consumed, end);
      if (HasFailure()) return;
    }
  }
}

TEST(IndependentChainsProperty, StopsThereWhateverMoreIsStored) {
  // Goal: stored results beyond the stop don't move the stop (invariant 3 of Plan). Method: let a
  // plan consume a random number of each chain's scans. Some of these scans are beyond the stop.
  // Then resume the run.
  for (const std::uint64_t index : property::cases(k_cases)) {
    Dice dice(k_cases + index);
    const Case given = random_case(dice);
    const std::uint64_t end = end_of(given);
    Session session(given, dice);
    for (std::uint32_t chain = 0; chain < given.options.chains; ++chain)
      session.replay(chain, dice.below(k_scans_max + 1));
    session.run();
    expect_end(session, given, end);
    if (HasFailure()) return;
  }
}

}  // namespace sleight::sampling::independent_chains_property_test
