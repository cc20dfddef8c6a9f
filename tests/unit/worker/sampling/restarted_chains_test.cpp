#include "worker/sampling/restarted_chains.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "tests/unit/worker/sampling/any_plan.h"

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_tour = 6;

/// Chains of an independence sampler on two states. The heavy state has half of the target's
/// probability, but only one proposal in ten proposes it. A scan is a pure function of (chain,
/// scan, previous state).
struct World {
  static constexpr double k_heavy_proposed = 0.1;
  static constexpr double k_heavy_weight = 9;  ///< makes p_w p_c equal for both states

  static random::Stream stream(std::uint32_t chain, std::uint64_t scan) {
    return random::Stream(
        {.seed = 5, .chain = base::ChainId{chain}, .purpose = random::Purpose::proposal}, scan);
  }

  struct State {
    bool is_heavy = false;
    std::uint64_t lineage = 0;
  };
  static State after(std::uint32_t chain, std::uint64_t scan, bool starts, const State& before) {
    random::Stream random = stream(chain, scan);
    const bool proposed = random.uniform() < k_heavy_proposed;
    const double ratio = (proposed ? k_heavy_weight : 1) / (before.is_heavy ? k_heavy_weight : 1);
    if (!starts && random.uniform() >= ratio) return before;
    return {.is_heavy = proposed, .lineage = plan::lineage_from({}, scan)};
  }

  /// Probability of the heavy state after `scans` scans from a start.
  static double heavy_after(std::uint64_t scans) {
    double heavy = k_heavy_proposed;
    for (std::uint64_t scan = 0; scan < scans; ++scan)
      heavy =
          heavy * (1 - (1 - k_heavy_proposed) / k_heavy_weight) + (1 - heavy) * k_heavy_proposed;
    return heavy;
  }
};

class Work {
 public:
  explicit Work(std::uint64_t seed)
      : random_({.seed = seed, .purpose = random::Purpose::scene}, 0) {}

  void carry_out(RestartedChains& plan, std::size_t workers) {
    std::vector<plan::Unit> out;
    while (true) {
      while (out.size() < workers) {
        const auto unit = plan.next_unit(
            static_cast<std::uint32_t>(1 + random::UniformInteger{.count = 9}.draw(random_)));
        if (!unit) break;
        EXPECT_EQ(unit->starts, unit->first_scan.value % k_tour == 0);
        EXPECT_LE(unit->first_scan.value % k_tour + unit->scans, k_tour);
        out.push_back(*unit);
      }
      if (out.empty()) return;
      const auto at =
          static_cast<std::ptrdiff_t>(random::UniformInteger{.count = out.size()}.draw(random_));
      const plan::Unit unit = out[static_cast<std::size_t>(at)];
      out.erase(out.begin() + at);
      plan.consume(unit.replica, unit.first_scan, records_of(unit));
    }
  }

  static double log_p_of(std::uint32_t chain, std::uint64_t scan) {
    return -static_cast<double>(3 * scan + chain);
  }
  /// States by chain and scan.
  const std::map<std::uint32_t, std::vector<World::State>>& states() const { return states_; }

 private:
  std::vector<plan::ScanRecord> records_of(const plan::Unit& unit) {
    std::vector<World::State>& states = states_[unit.replica.chain.value];
    std::vector<plan::ScanRecord> records;
    for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
      const World::State before = states.empty() ? World::State{} : states.back();
      states.push_back(World::after(unit.replica.chain.value, unit.first_scan.value + nth,
                                    unit.starts && nth == 0, before));
      plan::ScanRecord& record = records.emplace_back();
      // In either state, a scan satisfies the constraint with probability 2/3.
      random::Stream satisfies(
          {.seed = 6, .chain = unit.replica.chain, .purpose = random::Purpose::counted},
          unit.first_scan.value + nth);
      record.satisfied = satisfies.uniform() < 2.0 / 3;
      record.lineage = states.back().lineage;
      record.log_prior = log_p_of(unit.replica.chain.value, unit.first_scan.value + nth);
    }
    return records;
  }

  random::Stream random_;
  std::map<std::uint32_t, std::vector<World::State>> states_;
};

RestartedChainsOptions options(std::optional<std::uint64_t> scans,
                               std::optional<std::uint64_t> solutions) {
  return {.seed = 5,
          .chains = 3,
          .tour_scans = k_tour,
          .scans = scans,
          .independent_solutions = solutions};
}

TEST(RestartedChains, CountsTheLastScanOfATour) {
  // Goal: a solution has the distribution of a chain's state at the end of a tour. States that
  // begin a lineage have a different distribution. Method: compare the share of heavy states in
  // 20,000 solutions with the exact probability.
  RestartedChains plan(options({}, 20000));
  Work work(1);
  work.carry_out(plan, 4);
  EXPECT_TRUE(plan.finished());
  EXPECT_GE(plan.solutions_found(), 20000U);
  EXPECT_LE(plan.solutions_found(), 20002U);

  expect_told_as_counted(plan, 11, &Work::log_p_of);

  double heavy = 0;
  double counted = 0;
  for (const plan::DrawPart& part : plan.draws().parts) {
    EXPECT_EQ(part.count, 1U);
    EXPECT_EQ(part.first_scan % k_tour, k_tour - 1);
    for (std::uint32_t chain = 0; chain < 3; ++chain) {
      if (!part.counted[chain]) continue;
      EXPECT_EQ(*part.counted[chain], part.first_scan);
      ++counted;
      heavy += work.states().at(chain)[part.first_scan].is_heavy ? 1 : 0;
    }
  }
  EXPECT_EQ(counted, static_cast<double>(plan.solutions_found()));
  const double expected = World::heavy_after(k_tour - 1);
  EXPECT_NEAR(heavy / counted, expected, 5 * std::sqrt(0.25 / counted));

  double first_visits = 0;
  double heavy_visits = 0;
  for (const auto& [chain, states] : work.states())
    for (std::size_t scan = 0; scan < states.size(); ++scan) {
      if (plan::scan_of_lineage(states[scan].lineage) != scan) continue;
      ++first_visits;
      heavy_visits += states[scan].is_heavy ? 1 : 0;
    }
  EXPECT_LT(heavy_visits / first_visits, 0.6 * expected);
}

TEST(RestartedChains, EndAlikeHoweverTheyAreRun) {
  // Goal: a run's end and its counts depend only on the results. A run with a limit at the same
  // scan has the same counts. Method: compare three runs: a run by one worker, a run by five
  // workers, and a run with that limit.
  RestartedChains alone(options({}, 7));
  Work(2).carry_out(alone, 1);
  RestartedChains many(options({}, 7));
  Work(3).carry_out(many, 5);
  EXPECT_EQ(alone.scans_common() % k_tour, 0U);
  const auto same_as_alone = [&](const RestartedChains& other) {
    EXPECT_EQ(other.scans_common(), alone.scans_common());
    EXPECT_EQ(other.solutions_found(), alone.solutions_found());
    EXPECT_EQ(other.draws().count, alone.draws().count);
    for (std::size_t part = 0; part < alone.draws().parts.size(); ++part)
      EXPECT_EQ(other.draws().parts[part].counted, alone.draws().parts[part].counted);
  };
  same_as_alone(many);
  RestartedChains cut(options(alone.scans_common(), {}));
  Work(4).carry_out(cut, 2);
  same_as_alone(cut);
  EXPECT_EQ(cut.scans_total(), 3 * alone.scans_common());
  EXPECT_EQ(alone.solutions_wanted(), 7U);
}

TEST(RestartedChains, AToursBeginningIsNoDraw) {
  // Goal: a run that ends within a tour has only the draws of its whole tours. Method: end a run
  // after 2 1/3 tours.
  RestartedChains plan(options(2 * k_tour + 2, {}));
  Work(5).carry_out(plan, 2);
  EXPECT_TRUE(plan.finished());
  EXPECT_EQ(plan.scans_common(), 2 * k_tour + 2);
  EXPECT_EQ(plan.draws().count, 2U);
}

}  // namespace
}  // namespace sleight::sampling
