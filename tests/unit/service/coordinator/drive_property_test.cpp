// A run's result doesn't depend on the crew or on stops.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "service/coordinator/drive.h"
#include "tests/support/property.h"
#include "tests/unit/service/coordinator/fakes.h"
#include "worker/sampling/independent_chains.h"

namespace sleight::coordinator::drive_property_test {

constexpr std::uint64_t k_seed = 1618;
constexpr std::uint32_t k_chains = 4;
constexpr std::uint64_t k_round_scans = 10;
constexpr std::uint64_t k_solutions = 40;

/// Computes the scan at which a run for k_solutions must stop, from the example records.
std::uint64_t scans_at_stop() {
  std::uint64_t end = 0;
  for (std::uint64_t length = k_round_scans;; length *= 2) {
    end += length;
    std::set<std::pair<std::uint32_t, std::uint64_t>> solved;
    for (std::uint32_t chain = 0; chain < k_chains; ++chain) {
      for (std::uint64_t scan = 0; scan < end; ++scan) {
        const plan::ScanRecord record = store::testing::record_of(chain, scan);
        if (record.satisfied) solved.emplace(chain, record.lineage);
      }
    }
    if (solved.size() >= k_solutions) return end;
  }
}

class DriveProperty : public store::testing::RunFolder {};

TEST_F(DriveProperty, AnyCrewAndAnyStopsGiveOneResult) {
  // Goal: results don't depend on when and where units complete, what they cost, which states are
  // lost, and where sessions stop or fail. Method: run sessions that stop or fail at random. Choose
  // workers, threads, costs, the order of units, and lost states at random. Compare the final scan
  // and every stored bit with the example records. The crews must hold states and lose some of
  // them.
  const std::uint64_t end = scans_at_stop();
  EXPECT_GT(end, 2 * k_round_scans);
  std::uint64_t states_held = 0;
  std::uint64_t states_lost = 0;
  for (const std::uint64_t run : property::cases(property::of_tier(5, 15))) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, run);
    const auto below = [&](std::uint64_t count) {
      return random::UniformInteger{.count = count}.draw(stream);
    };
    const std::string folder = path(fmt::format("run-{}", run));
    std::filesystem::create_directory(folder);
    base::ManualClock clock;
    DriveOutcome outcome{.end = DriveEnd::stop_requested};
    for (int session = 0; outcome.end != DriveEnd::finished; ++session) {
      sampling::IndependentChains plan(
          {.chains = k_chains,
           .round_scans = k_round_scans,
           .stop = {.scans = {}, .rounds = {}, .independent_solutions = k_solutions}});
      std::uint64_t units_left = 1 + below(30);
      const bool fails = below(3) == 0;
      const bool forgetful = below(2) == 0;
      testing::FakeCrew crew(
          clock,
          {.workers = static_cast<std::uint32_t>(1 + below(3)),
           .threads = static_cast<std::uint32_t>(1 + below(3)),
           .cost_s = [&](const plan::Unit&) { return 1e-4 * static_cast<double>(below(99)); },
           .choose = [&](std::size_t waiting) { return below(waiting); },
           .before =
               [&](const plan::Unit&) {
                 if (fails && --units_left == 0) throw session;
               },
           .forgets =
               [&](const plan::Unit&) {
                 if (!forgetful || below(4) > 0) return false;
                 ++states_lost;
                 return true;
               }});
      store::RunStore store(folder, store::testing::example_identity(k_chains));
      try {
        outcome = drive(plan, store, crew, clock,
                        {.stop_requested = [&] { return !fails && --units_left == 0; }});
      } catch (int failed_session) {
        ASSERT_EQ(failed_session, session);
      }
      states_held += crew.states_held();
    }
    EXPECT_EQ(outcome.reached.scans, end);
    store::RunStore store(folder, store::testing::example_identity(k_chains));
    for (std::uint32_t chain = 0; chain < k_chains; ++chain)
      store::testing::expect_stored(folder, store, chain, end);
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(states_held, 100U);
  EXPECT_GT(states_lost, 10U);
}

}  // namespace sleight::coordinator::drive_property_test
