#include "tests/cluster/scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/cluster/dice.h"
#include "worker/sampling/annealed_importance.h"
#include "worker/sampling/burnt_in_chains.h"
#include "worker/sampling/independent_chains.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"
#include "worker/sampling/simulated_tempering.h"

namespace sleight::cluster {
namespace {

std::uint64_t quotient_up(std::uint64_t a, std::uint64_t b) {
  return (a + b - 1) / b;
}

void choose_independent(Scenario& scenario, Dice& dice, std::uint64_t units) {
  const double workers = scenario.workers;
  sampling::IndependentChainsOptions options;
  options.chains = static_cast<std::uint32_t>(dice.log_uniform(workers / 4 + 1, 2 * workers + 1));
  const std::uint64_t scans = quotient_up(units, options.chains);
  options.round_scans = scans;
  if (scenario.method == Method::islands) {
    // The first rounds are a burn-in and don't count.
    options.has_islands = true;
    options.round_scans = std::max<std::uint64_t>(scans / 8, 1);
    options.burn_in_scans = options.round_scans;
    options.stop.scans = scans + options.burn_in_scans;
    scenario.make_plan = [options] {
      return std::make_unique<sampling::IndependentChains>(options);
    };
    return;
  }
  if (dice.chance(0.3)) options.anneal_scans = dice.whole(1, scans);
  switch (dice.whole(0, 2)) {
    case 0:
      options.stop.scans = scans + options.anneal_scans;
      break;
    case 1:
      options.stop.rounds = scenario.workers < 200 ? 2 : 1;
      break;
    default:
      options.stop.rounds = 2;
      options.stop.independent_solutions = options.chains / 2 + 1;
  }
  scenario.make_plan = [options] { return std::make_unique<sampling::IndependentChains>(options); };
}

sampling::LadderOptions ladder_of(const Scenario& scenario, Dice& dice, std::uint32_t levels) {
  return {.seed = scenario.swap_seed,
          .chain = {},
          .first_ladder = sampling::first_ladder(levels),
          .levels_chosen = dice.chance(0.5),
          .levels_max = 32,
          .ladder_adapts = dice.chance(0.8),
          .has_scale = {true, dice.chance(0.5)},
          .round_scans = 8,
          .anneal_scans = dice.chance(0.3) ? dice.whole(1, 12) : 0};
}

void choose_tempering(Scenario& scenario, Dice& dice, std::uint64_t units) {
  const bool is_large = scenario.workers > 500;
  const auto levels = static_cast<std::uint32_t>(is_large ? dice.whole(8, 32) : dice.whole(2, 24));
  const double filled = scenario.workers * dice.uniform(0.1, 1.2) / levels;
  sampling::ParallelTemperingOptions options;
  options.ladders = static_cast<std::uint32_t>(std::clamp(filled, 1.0, 256.0));
  options.ladder = ladder_of(scenario, dice, levels);
  const std::uint64_t scans = quotient_up(units, std::uint64_t{options.ladders} * levels);
  const auto rounds = static_cast<std::uint32_t>(is_large ? dice.whole(1, 2) : dice.whole(1, 4));
  options.ladder.round_scans = std::max<std::uint64_t>(scans >> (rounds - 1), 2);
  options.stop.rounds = rounds;
  if (dice.chance(0.3)) options.stop.scans = options.ladder.anneal_scans + scans;
  if (dice.chance(0.3)) options.stop.independent_solutions = options.ladders * 3;
  scenario.make_plan = [options] { return std::make_unique<sampling::ParallelTempering>(options); };
}

void choose_burnt_in(Scenario& scenario, Dice& dice, std::uint64_t units) {
  const bool has_lanes = scenario.method == Method::annealed_importance;
  const auto levels = static_cast<std::uint32_t>(dice.whole(2, 8));
  sampling::BurntInOptions options;
  options.chains = static_cast<std::uint32_t>(
      dice.whole(1, std::clamp<std::uint64_t>(scenario.workers / 4, 1, 32)));
  options.ladder = ladder_of(scenario, dice, levels);
  options.ladder.levels_max = 12;
  options.burn_in_rounds = static_cast<std::uint32_t>(dice.whole(1, 2));
  const std::uint64_t burn_in = options.ladder.anneal_scans + 8 * options.burn_in_rounds * 2;
  std::uint32_t lanes = 1;
  if (has_lanes) {
    lanes = std::clamp(scenario.workers / options.chains, 1U, 32U);
    const auto steps = static_cast<std::uint32_t>(dice.whole(1, 3));
    options.go_on = [lanes, steps](const sampling::BurnIn& burnt) {
      return std::make_unique<sampling::AnnealedImportance>(burnt, lanes, steps);
    };
  } else {
    options.go_on = [](const sampling::BurnIn& burnt) {
      return std::make_unique<sampling::SimulatedTempering>(burnt);
    };
  }
  options.stop.scans = burn_in + quotient_up(units, std::uint64_t{options.chains} * lanes);
  scenario.make_plan = [options] { return std::make_unique<sampling::BurntInChains>(options); };
}

void choose_plan(Scenario& scenario, Dice dice, std::uint64_t units) {
  switch (scenario.method) {
    case Method::independent:
    case Method::islands:
      return choose_independent(scenario, dice, units);
    case Method::tempering:
      return choose_tempering(scenario, dice, units);
    case Method::simulated_tempering:
    case Method::annealed_importance:
      return choose_burnt_in(scenario, dice, units);
  }
}

core::SchedulerOptions scheduler_options(Dice& dice) {
  core::SchedulerOptions options;
  options.lease_s = dice.log_uniform(0.01, 0.3);
  options.lease_factor = dice.uniform(2, 20);
  options.blocks_ahead = static_cast<std::uint32_t>(dice.whole(0, 2));
  options.size.target_s = dice.log_uniform(0.5e-3, 20e-3);
  options.size.least_s = options.size.target_s / 5;
  options.size.handling_s = dice.log_uniform(1e-7, 50e-6);
  options.size.target_s_max = 0.1;
  return options;
}

constexpr Method k_methods[] = {Method::independent,        Method::islands,
                                Method::tempering,          Method::tempering,
                                Method::tempering,          Method::simulated_tempering,
                                Method::annealed_importance};

}  // namespace

std::string Case::name() const {
  static constexpr const char* k_names[] = {"independent chains", "islands", "parallel tempering",
                                            "simulated tempering", "annealed importance"};
  return fmt::format("{}, {} workers, {} scans, {} faults",
                     k_names[static_cast<std::size_t>(scenario.method)], scenario.workers,
                     expected.scans(), scenario.faults.size());
}

void expect_serial(Case& of) {
  base::ManualClock clock;
  HashWorkerOptions right = of.scenario.work;
  right.mistake = Mistake::none;
  const HashWorker worker(right, clock);
  const std::unique_ptr<plan::Plan> plan = of.scenario.make_plan();
  of.expected = run_serially(*plan, worker);
  of.work_s = clock.now_s();
  of.longest_s = 0;
  for (const auto& [key, replica] : of.expected.replicas) {
    double path_s = 0;
    for (std::uint64_t scan = replica.first_scan; scan < replica.next_scan(); ++scan)
      path_s += right.costs.of(key, scan);
    of.longest_s = std::max(of.longest_s, path_s);
  }
}

Case case_of(std::uint64_t seed, const CaseChoice& choice) {
  Dice dice(seed, Dice::Part::scenario);
  Case made;
  Scenario& scenario = made.scenario;
  scenario.seed = seed;
  scenario.mistake = choice.mistake;
  scenario.workers = static_cast<std::uint32_t>(
      std::min<double>(dice.log_uniform(1, choice.workers_max + 1), choice.workers_max));
  scenario.threads_max = dice.chance(0.2) ? static_cast<std::uint32_t>(dice.whole(2, 4)) : 1;
  const Method drawn = k_methods[dice.whole(0, std::size(k_methods) - 1)];
  scenario.method = choice.method.value_or(drawn);
  scenario.swap_seed = seed;
  scenario.work = {.hash = {.seed = seed,
                            .roughness = {1, 4, 12},
                            .broken = dice.chance(0.3) ? 0.1 : 0,
                            .satisfied = 0.1},
                   .costs = {.seed = seed, .least_s = 1e-4},
                   .states_held_bytes = dice.chance(0.2) ? 0 : dice.whole(300, 4000),
                   .id = 0,
                   .mistake = choice.mistake};
  scenario.scheduler = scheduler_options(dice);
  scenario.handling_s = dice.log_uniform(1e-6, 50e-6);
  // If a lease is too short to handle a message from each worker, the coordinator assigns only
  // copies of blocks.
  const double round_s = scenario.handling_s * scenario.workers * scenario.threads_max;
  scenario.scheduler.lease_s = std::max(scenario.scheduler.lease_s, 10 * round_s);
  scenario.scheduler.ask_every_s = scenario.scheduler.lease_s / 3;
  scenario.tick_s = scenario.scheduler.lease_s / 8;
  scenario.commit_every_s = dice.log_uniform(0.002, 0.05);
  scenario.hello_every_s = 2 * scenario.scheduler.lease_s;

  // If a plan's length depends on its results, the plan may be too short. If so, draw a larger
  // plan.
  const std::uint64_t least = std::max<std::uint64_t>(k_units_per_worker * scenario.workers, 300);
  for (std::uint64_t units = least;; units *= 2) {
    choose_plan(scenario, dice, units);
    expect_serial(made);
    if (made.expected.scans() >= least) break;
  }
  const double duration_s = std::max(made.work_s / scenario.workers, made.longest_s);
  scenario.faults = faults_of(seed, scenario.workers, 1.5 * duration_s);
  return made;
}

}  // namespace sleight::cluster
