// `sleight-reuse-table` measures savings by reuse of similar states, for docs/MEASUREMENTS.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include "common/base/version.h"
#include "tests/thesis/sampling/methods.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/worlds/spelling/spelling.h"

namespace {

using namespace sleight;
using worlds::spelling::Kind;
using worlds::spelling::Replays;
using worlds::spelling::Spelling;

constexpr const char* k_kind_names[] = {"change all", "change vertices", "change ball",
                                        "disable balls", "enable balls"};
constexpr std::uint32_t k_kinds = worlds::spelling::k_thesis_kinds;

struct Events {
  std::uint64_t all = 0;
  std::uint64_t simulated = 0;
};

/// Balls that spell. Simulates each candidate a second time from scratch, and compares both
/// results. Not thread-safe.
struct Observed : Spelling {
  Observed(const worlds::spelling::Parameters& parameters, Events& last)
      : Spelling(parameters), last_(&last) {}
  Outcome simulate_from(const State& candidate, const State& state, const Outcome& outcome) const {
    Outcome result = Spelling::simulate_from(candidate, state, outcome);
    const Outcome whole = Spelling::simulate_from(candidate, candidate, {});
    if (outcome_values(result) != outcome_values(whole) || result.filling != whole.filling) {
      fmt::print(stderr, "reuse makes a difference\n");
      std::exit(1);
    }
    *last_ = {};
    if (whole.history) {
      const std::uint64_t all = whole.history->simulated;
      *last_ = {.all = all, .simulated = result.history ? result.history->simulated : all};
    }
    return result;
  }
  Events* last_;
};

struct Tally {
  std::uint64_t iterations = 0;
  std::uint64_t simulations = 0;
  Events events;
  double replayed_s = 0;  ///< time of iterations with reuse
  double fresh_s = 0;     ///< time without reuse
  void add(const Tally& other) {
    iterations += other.iterations;
    simulations += other.simulations;
    events.all += other.events.all;
    events.simulated += other.events.simulated;
    replayed_s += other.replayed_s;
    fresh_s += other.fresh_s;
  }
};
using Tallies = std::array<Tally, k_kinds>;

/// Runs a chain of Algorithm 2.1 with and without reuse, in turns because the machine's speed
/// varies.
Tallies timed_chain(const worlds::spelling::Parameters& parameters, std::uint64_t seed,
                    std::uint64_t iterations) {
  constexpr std::uint64_t k_turn = 200;
  const sampling::ChainStreams streams{.seed = seed, .chain = {}, .replica = {}};
  Tallies tallies{};
  const Spelling reuses(parameters, Replays::yes);
  const Spelling fresh(parameters, Replays::no);
  auto with = sampling::draw_afresh(reuses, streams, 0);
  auto without = with;
  for (std::uint64_t begin = 1; begin <= iterations; begin += k_turn) {
    const std::uint64_t end = std::min(iterations + 1, begin + k_turn);
    const auto take_turn = [&](const Spelling& world, auto& sample, double Tally::*time_s) {
      for (std::uint64_t i = begin; i < end; ++i) {
        const double begin_s = thesis::thread_cpu_s();
        const auto report = metropolis_hastings_step(world, 1.0, streams, i, sample);
        Tally& tally = tallies[report.kind];
        tally.*time_s += thesis::thread_cpu_s() - begin_s;
        if (&sample != &with) continue;
        ++tally.iterations;
        tally.simulations += report.simulated ? 1U : 0U;
      }
    };
    take_turn(reuses, with, &Tally::replayed_s);
    take_turn(fresh, without, &Tally::fresh_s);
  }
  return tallies;
}

/// Runs the same chain as timed_chain(), and counts the events of its simulations.
void count_events(const worlds::spelling::Parameters& parameters, std::uint64_t seed,
                  std::uint64_t iterations, Tallies& tallies) {
  const sampling::ChainStreams streams{.seed = seed, .chain = {}, .replica = {}};
  Events last;
  const Observed world(parameters, last);
  auto sample = sampling::draw_afresh(world, streams, 0);
  for (std::uint64_t i = 1; i <= iterations; ++i) {
    last = {};
    const auto report = metropolis_hastings_step(world, 1.0, streams, i, sample);
    tallies[report.kind].events.all += last.all;
    tallies[report.kind].events.simulated += last.simulated;
  }
}

Tallies run_chain(const worlds::spelling::Parameters& parameters, std::uint64_t seed,
                  std::uint64_t iterations) {
  Tallies tallies = timed_chain(parameters, seed, iterations);
  count_events(parameters, seed, iterations, tallies);
  return tallies;
}

void print_row(const std::string& scene, const std::string& kind, const Tally& tally) {
  const auto all = static_cast<double>(tally.events.all);
  const auto iterations = static_cast<double>(tally.iterations);
  fmt::print(
      "| {} | {} | {} | {} | {:.0f}% | {:.0f} | {:.0f} | {:.2f} |\n", scene, kind, tally.iterations,
      tally.simulations, 100 * (1 - static_cast<double>(tally.events.simulated) / all),
      iterations / tally.replayed_s, iterations / tally.fresh_s, tally.fresh_s / tally.replayed_s);
}

void print(const std::string& scene, const Tallies& tallies) {
  Tally all;
  Tally local;
  for (std::uint32_t kind = 0; kind < k_kinds; ++kind) {
    if (tallies[kind].iterations == 0) continue;
    print_row(scene, k_kind_names[kind], tallies[kind]);
    all.add(tallies[kind]);
    if (kind != static_cast<std::uint32_t>(Kind::change_all)) local.add(tallies[kind]);
  }
  print_row(scene, "all local kinds", local);
  print_row(scene, "whole mixture", all);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"What reuse saves, by kind of proposal: the table of docs/MEASUREMENTS"};
  app.set_version_flag("--version", "sleight-reuse-table " + std::string(base::version()));
  std::uint64_t iterations = 20'000;
  std::uint64_t seed = 1;
  app.add_option("--iterations", iterations, "Of each chain")->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  app.footer("Example:\n  sleight-reuse-table --iterations 100000");
  CLI11_PARSE(app, argc, argv);
  fmt::print(
      "| scene | kind | iterations | simulations | events reused | iterations/s | without reuse "
      "| ratio |\n|---|---|--:|--:|--:|--:|--:|--:|\n");
  worlds::spelling::Parameters parameters;
  print("HI", run_chain(parameters, seed, iterations));
  parameters.pattern =
      worlds::spelling::pattern_of_word("ACM", worlds::spelling::Font::rows_5).value();
  parameters.constraint.log_lambda = 7.25;
  print("ACM", run_chain(parameters, seed, iterations));
  return 0;
}
