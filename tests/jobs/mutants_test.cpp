// Control test. Each service has one known mistake. The ledger or the time limit must catch the
// mistake.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <string>

#include "tests/jobs/service.h"
#include "tests/jobs/wrong_parts.h"

namespace sleight::jobs::simulated {
namespace {

/// Exit status of a process that checks a run.
enum Verdict : int { k_right = 0, k_violation = 11, k_unfinished = 12 };

/// Maximum runs per mistake.
constexpr std::uint64_t k_seeds = 30;

Scenario mutant(std::uint64_t seed, Mistake mistake, Mistake looks_like) {
  Scenario scenario = scenario_of(seed, where_it_shows(looks_like));
  scenario.mistake = mistake;
  return scenario;
}

Verdict judged(const Scenario& scenario) {
  const Outcome outcome = Service(scenario).run(liveness_bound_s(scenario));
  if (!outcome.violation.empty()) return k_violation;
  return outcome.is_finished ? k_right : k_unfinished;
}

/// A wrong service may fail a CHECK, so it runs in its own process.
int status_of(const Scenario& scenario) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(k_unfinished);
    _exit(judged(scenario));
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::string words_for(int status) {
  if (status == k_violation) return "the ledger";
  if (status == k_unfinished) return "no end";
  return status < 0 ? "a check" : "nothing";
}

class Mutant : public testing::TestWithParam<std::size_t> {};

TEST_P(Mutant, IsCaught) {
  // Goal: the tests of services detect each known mistake. Method: run services with a mistake
  // until one fails. The same services without the mistake must pass.
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
}  // namespace sleight::jobs::simulated
