// Control test of contract C1. Each cluster has one known mistake.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <string>

#include "tests/cluster/cluster.h"

namespace sleight::cluster {
namespace {

/// Exit status of a process that checks a run.
enum Verdict : int { k_right = 0, k_digest = 10, k_violation = 11, k_unfinished = 12 };

/// Maximum runs per mistake.
constexpr std::uint64_t k_seeds = 12;

/// Returns a method whose runs can reveal the mistake.
Method method_of(Mistake mistake) {
  const bool is_of_ladders = mistake == Mistake::double_swap || mistake == Mistake::past_the_edge ||
                             mistake == Mistake::swaps_in_any_order;
  return is_of_ladders ? Method::tempering : Method::independent;
}

Case mutant(std::uint64_t seed, Mistake mistake, Mistake looks_like) {
  Case of = case_of(seed, {.method = method_of(looks_like), .workers_max = 64, .mistake = mistake});
  // Use one scan per block, so that no worker decides a swap before the plan does.
  if (looks_like == Mistake::swaps_in_any_order) of.scenario.scheduler.size.scans_max = 1;
  // Make sessions so short that assignment numbers are reused while old messages are in transit.
  if (looks_like == Mistake::stale_epoch) {
    of.scenario.restart_s_max = 1e-3;
    for (int i = 1; i <= 20; ++i)
      of.scenario.faults.push_back({.kind = Fault::Kind::coordinator_dies, .at_s = 3e-3 * i});
  }
  return of;
}

Verdict judged(const Case& of) {
  const Outcome outcome = Cluster(of).run(liveness_bound_s(of));
  if (outcome.digest != digest_of(of.expected) && outcome.is_finished) return k_digest;
  if (!outcome.violation.empty()) return k_violation;
  return outcome.is_finished ? k_right : k_unfinished;
}

/// A wrong cluster may fail a CHECK, so it runs in its own process.
int status_of(const Case& of) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(k_unfinished);
    _exit(judged(of));
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::string words_for(int status) {
  if (status == k_digest) return "another digest";
  if (status == k_violation) return "the store's invariants";
  if (status == k_unfinished) return "no end";
  return status < 0 ? "a check" : "nothing";
}

class Mutant : public testing::TestWithParam<std::size_t> {};

TEST_P(Mutant, IsCaught) {
  // Goal: the tests of clusters detect each known mistake in the distribution of work. Method: run
  // clusters with a mistake until one fails. The same clusters without the mistake must pass.
  const auto& [mistake, name] = k_mistakes[GetParam()];
  int status = k_right;
  std::uint64_t seed = 0;
  while (status == k_right && seed < k_seeds)
    status = status_of(mutant(++seed, mistake, mistake));
  EXPECT_NE(status, k_right) << name << " passes " << k_seeds << " seeds";
  for (std::uint64_t right = 1; right <= seed; ++right)
    EXPECT_EQ(judged(mutant(right, Mistake::none, mistake)), k_right) << "seed " << right;
  fmt::print("{}: seed {}, by {}\n", name, seed, words_for(status));
}

INSTANTIATE_TEST_SUITE_P(Mistakes, Mutant, testing::Range<std::size_t>(0, k_mistakes.size()),
                         [](const auto& mistake) {
                           return std::string(k_mistakes[mistake.param].second);
                         });

}  // namespace
}  // namespace sleight::cluster
