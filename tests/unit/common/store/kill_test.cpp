#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "common/store/run_store.h"
#include "tests/support/property.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::store::kill_test {

constexpr std::uint64_t k_seed = 90125;
constexpr std::uint32_t k_chains = 3;

std::uint64_t below(std::uint64_t count, random::Stream& stream) {
  return random::UniformInteger{.count = count}.draw(stream);
}

/// Continues the run until the process is killed. Reports the value of committed() after each
/// put().
[[noreturn]] void store_until_killed(const std::string& folder, random::Stream stream, int report) {
  const RunLock lock(folder);
  RunStore store(folder, testing::example_identity(k_chains));
  std::vector<std::uint64_t> next(k_chains, 0);
  for (const ReplicaProgress& replica : store.progress())
    next[replica.replica.chain.value] = replica.next_scan;
  while (true) {
    const auto chain = static_cast<std::uint32_t>(below(k_chains, stream));
    const auto scans = static_cast<std::uint32_t>(1 + below(12, stream));
    store.put(testing::result_of(chain, next[chain], scans));
    next[chain] += scans;
    if (below(50, stream) == 0) store.flush();
    const std::uint64_t committed = store.committed();
    if (::write(report, &committed, sizeof committed) != sizeof committed) ::_exit(1);
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
}

std::uint64_t run_and_kill(const std::string& folder, random::Stream stream) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const std::chrono::microseconds life(5'000 + below(100'000, stream));
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    store_until_killed(folder, stream, ends[1]);
  }
  ::close(ends[1]);
  std::this_thread::sleep_for(life);
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << "the child ended by itself";
  std::uint64_t reported = 0;
  while (::read(ends[0], &reported, sizeof reported) == sizeof reported) {
  }
  ::close(ends[0]);
  return reported;
}

class KilledStore : public testing::RunFolder {};

TEST_F(KilledStore, KeepsWhatItReported) {
  // Goal: if a process is killed at any moment, the store keeps all scans that committed() counted.
  // The store has no gap and the right state, and the next session continues from this state.
  // Method: run many sessions of one run. Kill each session's process (SIGKILL) at a random moment.
  std::vector<std::uint64_t> next(k_chains, 0);
  const std::uint64_t kills = property::of_tier(10, 50);
  std::uint64_t reported_in_all = 0;
  for (const std::uint64_t kill : property::in_turn(kills)) {
    const std::uint64_t reported = run_and_kill(
        folder(), random::Stream({.seed = k_seed, .purpose = random::Purpose::prior}, kill));
    reported_in_all += reported;

    const RunLock lock(folder());
    RunStore store(folder(), testing::example_identity(k_chains));
    std::uint64_t gained = 0;
    for (const ReplicaProgress& replica : store.progress()) {
      std::uint64_t& before = next[replica.replica.chain.value];
      ASSERT_GE(replica.next_scan, before);
      gained += replica.next_scan - before;
      before = replica.next_scan;
    }
    ASSERT_GE(gained, reported);
    if (kill % 10 == 9) {
      for (std::uint32_t chain = 0; chain < k_chains; ++chain)
        testing::expect_stored(folder(), store, chain, next[chain]);
    }
    if (HasFailure()) return;
  }
  if (!property::all_cases()) return;
  // Negative control: the sessions did commit before they were killed.
  EXPECT_GT(reported_in_all, 20 * kills);
}

}  // namespace sleight::store::kill_test
