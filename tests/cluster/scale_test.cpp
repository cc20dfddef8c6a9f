// Utilisation of many workers in the simulated cluster. Scans take 1 ms on average, log-uniform
// over a factor of 100. Messages take 20 to 200 us, and the coordinator needs 50 us for each
// message. There are no faults, and the scheduler has its default options.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "common/math/elementary.h"
#include "tests/cluster/cluster.h"
#include "tests/support/property.h"
#include "worker/sampling/independent_chains.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"

namespace sleight::cluster {
namespace {

struct Size {
  std::uint32_t workers = 1;
  std::uint32_t ladders = 1;
  std::uint32_t levels = 32;
  std::uint64_t scans = 64;
};

Case case_of_size(const Size& size) {
  sampling::ParallelTemperingOptions options;
  options.ladders = size.ladders;
  options.ladder.first_ladder = sampling::first_ladder(size.levels);
  options.ladder.levels_chosen = false;
  options.ladder.round_scans = size.scans;
  options.stop.rounds = 1;
  Case of;
  Scenario& scenario = of.scenario;
  scenario.method = Method::tempering;
  scenario.make_plan = [options] { return std::make_unique<sampling::ParallelTempering>(options); };
  scenario.workers = size.workers;
  scenario.work.costs.least_s = 1e-3 / Costs{.seed = 1, .least_s = 1}.mean_s();
  scenario.work.states_held_bytes = 1'000'000;
  scenario.handling_s = 50e-6;
  scenario.hello_every_s = 10;
  expect_serial(of);
  return of;
}

Outcome checked_run(const Case& of) {
  Outcome outcome = Cluster(of).run(liveness_bound_s(of));
  EXPECT_TRUE(outcome.is_finished);
  EXPECT_EQ(outcome.digest, digest_of(of.expected));
  return outcome;
}

/// Prints to the terminal, and appends to the file that SLEIGHT_OUT names.
void print_line(const std::string& line) {
  fmt::print("{}\n", line);
  const char* path = std::getenv("SLEIGHT_OUT");
  if (path == nullptr) return;
  std::FILE* file = std::fopen(path, "a");
  ASSERT_NE(file, nullptr) << path;
  fmt::print(file, "{}\n", line);
  std::fclose(file);
}

/// Returns the time in which all levels make their scans, if no level waits for workers or
/// messages. If two levels swap, both wait for the slower level.
double critical_path_s(const Case& of, const Size& size) {
  std::vector<double> done_s(size.levels, 0.0);
  for (std::uint64_t scan = 0; scan < size.scans; ++scan) {
    // In a run, costs belong to replicas. Here costs belong to levels, which gives the same
    // distribution because all costs are independent.
    for (std::uint32_t level = 0; level < size.levels; ++level)
      done_s[level] += of.scenario.work.costs.of({{}, base::ReplicaId{level}}, scan);
    for (std::uint32_t level = scan % 2; level + 1 < size.levels; level += 2)
      done_s[level] = done_s[level + 1] = std::max(done_s[level], done_s[level + 1]);
  }
  return *std::ranges::max_element(done_s);
}

TEST(Scale, AThousandWorkersAreBusy) {
  // Goal: if there is at least one ladder per worker, up to 1,024 workers are busy at least 95% of
  // the time in the middle of a run. Method: simulate clusters of several sizes. Measure the
  // utilisation between the first and the last fifth of the scans. Also measure the whole run,
  // which starts and ends slowly.
  const bool is_long = property::long_run();
  print_line("| workers | ladders x levels | scans a block | amid the run | whole run | run |");
  print_line("|---|---|---|---|---|---|");
  for (const Size size : {Size{.workers = 128, .ladders = 128, .levels = 32, .scans = 100},
                          Size{.workers = 1024, .ladders = 512, .levels = 32, .scans = 20},
                          Size{.workers = 1024, .ladders = 1024, .levels = 32, .scans = 20},
                          Size{.workers = 1024, .ladders = 2048, .levels = 8, .scans = 40}}) {
    Size run = size;
    if (is_long) run.scans *= 5;
    const Case of = case_of_size(run);
    const Outcome outcome = checked_run(of);
    print_line(fmt::format(
        "| {} | {} x {} | {:.0f} | {:.1f}% | {:.1f}% | {:.1f} s |", run.workers, run.ladders,
        run.levels,
        static_cast<double>(outcome.counts.scans) / static_cast<double>(outcome.counts.blocks),
        100 * outcome.utilisation_amid, 100 * outcome.utilisation, outcome.end_s));
    if (run.ladders >= run.workers) {
      EXPECT_GE(outcome.utilisation_amid, 0.95);
    }
  }
}

/// Four chains of islands per worker. A scan takes 9 ms on average.
Case case_of_islands(std::uint32_t workers, double handling_s) {
  sampling::IndependentChainsOptions options;
  options.chains = 4 * workers;
  options.round_scans = 25;
  options.has_islands = true;
  options.stop.scans = 100;
  Case of;
  Scenario& scenario = of.scenario;
  scenario.method = Method::islands;
  scenario.make_plan = [options] { return std::make_unique<sampling::IndependentChains>(options); };
  scenario.workers = workers;
  scenario.work.costs.least_s = 9e-3 / Costs{.seed = 1, .least_s = 1}.mean_s();
  scenario.work.states_held_bytes = 1'000'000;
  scenario.handling_s = handling_s;
  scenario.scheduler.size.handling_s = handling_s;
  scenario.hello_every_s = 10;
  expect_serial(of);
  return of;
}

TEST(Scale, IslandsKeepAThousandWorkersBusy) {
  // Goal: chains of islands never wait, so 1,024 workers are busy nearly all the time. A whole run
  // takes about 3.6 s. Only the coordinator's time for the first messages of all workers limits the
  // utilisation. Method: simulate runs for each of two handling times per message. Compare the
  // results with a serial run.
  constexpr std::uint32_t k_workers = 1024;
  struct Asked {
    double handling_s;
    double utilisation;
  };
  for (const Asked asked : {Asked{50e-6, 0.95}, Asked{10e-6, 0.97}}) {
    const Case of = case_of_islands(k_workers, asked.handling_s);
    const Outcome outcome = checked_run(of);
    print_line(fmt::format(
        "islands, {} workers, {:.0f} us a message: {:.1f}% amid the run, {:.1f}% over a whole run "
        "of {:.2f} s, at best {:.2f} s",
        k_workers, 1e6 * asked.handling_s, 100 * outcome.utilisation_amid,
        100 * outcome.utilisation, outcome.end_s, of.work_s / k_workers));
    EXPECT_GE(outcome.utilisation, asked.utilisation);
  }
}

TEST(Scale, OneLadderAgainstWorkers) {
  // Goal: the utilisation of one ladder by different numbers of workers is near its theoretical
  // bounds. Method: simulate clusters of 1 to 64 workers. A ladder of N levels has at most N units
  // that can run at once. If c are the scans' costs and there are W workers, a run takes at least
  // sum(c) / W. A run also takes at least the time of the swaps' critical path. Each scan of a pair
  // waits for the slower level, so S scans take longer than S E[max(c1, c2)]. If costs are
  // log-uniform over a factor r, and q = log r:
  //   E[c] / E[max(c1, c2)] = (r - 1) / (2 (r - (r - 1) / q)).
  constexpr Size k_size{.workers = 1, .ladders = 1, .levels = 32, .scans = 600};
  constexpr double k_r = k_cost_spread;
  const double pairs = (k_r - 1) / (2 * (k_r - (k_r - 1) / math::log(k_r)));
  print_line("| workers | utilisation | critical path's bound | pairs' bound |");
  print_line("|---|---|---|---|");
  for (std::uint32_t workers = 1; workers <= 64; workers *= 2) {
    Size size = k_size;
    size.workers = workers;
    const Case of = case_of_size(size);
    const Outcome outcome = checked_run(of);
    const double path = std::min(1.0, of.work_s / (workers * critical_path_s(of, size)));
    const double of_pairs = std::min(1.0, pairs * size.levels / workers);
    print_line(fmt::format("| {} | {:.1f}% | {:.1f}% | {:.1f}% |", workers,
                           100 * outcome.utilisation, 100 * path, 100 * of_pairs));
    // The run's critical path depends on the replicas' costs. The computed path is another draw
    // from the same distribution.
    EXPECT_LE(outcome.utilisation, 1.1 * path);
    EXPECT_GE(outcome.utilisation, workers <= 4 ? 0.9 * path : 0.4 * path);
  }
}

}  // namespace
}  // namespace sleight::cluster
