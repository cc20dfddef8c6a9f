// Checks of weights: stepping stones, annealed importance sampling, simulated tempering.
#include <algorithm>
#include <cmath>
#include <string_view>

#include "common/base/check.h"
#include "tests/statistical/mutants/checks.h"
#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/run_serially.h"
#include "worker/sampling/annealed_importance.h"
#include "worker/sampling/parallel_tempering.h"
#include "worker/sampling/simulated_tempering.h"

namespace sleight::statistical {
namespace {

/// The sum of p_w p_c^beta.
double z_of(double beta) {
  double sum = 0;
  for (std::size_t i = 0; i < k_places; ++i)
    sum +=
        RuggedRing::k_prior[i] * (beta == 0 ? 1 : std::exp(beta * RuggedRing::k_log_constraint[i]));
  return sum;
}

double p_satisfied() {
  return RuggedRing::k_prior[5] + RuggedRing::k_prior[10];
}

sampling::BurnIn burn_in_of(std::uint64_t seed, std::uint32_t chain) {
  const std::vector<double>& ladder = ladder_of_checks();
  const std::vector<std::vector<double>> scales(ladder.size());
  return {.seed = seed,
          .chain = base::ChainId{chain},
          .scans = 0,
          .coolest = base::ReplicaId{0},
          .first_free = base::ReplicaId{1},
          .lineage = 0,
          .ladder = ladder,
          .scales = scales,
          .log_z_steps = {-0.1, -0.9, 0.3},  // Slightly wrong values.
          .next_ladder = ladder,
          .next_scales = scales};
}

plan::UnitResult go_on(sampling::ChainPart& part, const plan::UnitWorker& worker,
                       base::Bytes& state) {
  const std::optional<plan::Unit> unit = part.next_unit(UINT64_MAX, 1);
  CHECK(unit.has_value());
  plan::UnitResult result = worker.run(*unit, state);
  part.consume(unit->replica.replica, unit->first_scan.value, result.scans);
  state = result.state_after;
  return result;
}

std::vector<double> exp_of_row(const sampling::ChainPart& part, std::string_view name) {
  for (const sampling::ChainPart::Row& row : part.rows()) {
    if (row.name != name) continue;
    std::vector<double> values;
    for (const double x : row.values)
      values.push_back(std::exp(x));
    return values;
  }
  CHECK(false);
}

}  // namespace

/// Computes stepping stones from exact draws, and the mean of 1{satisfied} / p_c. Compares both
/// with values from enumeration.
std::vector<double> stones_weigh(const Mutant& mutant, std::uint64_t seed) {
  constexpr std::uint64_t k_scans = 20;
  const std::vector<double>& ladder = ladder_of_checks();
  Ring ring;
  ring.lies = mutant.lies;
  std::vector<std::vector<double>> steps(ladder.size() - 1);
  std::vector<double> inverse;
  for (std::uint64_t n = 0; n < 1500; ++n) {
    const std::uint64_t own = seed_of(seed, n);
    const ExactScans<Ring> exact(ring, own);
    const MutantWorker worker(mutant, exact);
    sampling::ParallelTempering plan(
        {.ladders = 1,
         .ladder = {.seed = own,
                    .chain = {},
                    .first_ladder = ladder,
                    .levels_chosen = false,
                    .levels_max = 64,
                    .ladder_adapts = false,
                    .has_scale = {},
                    .round_scans = k_scans,
                    .anneal_scans = 0},
         .stop = {.scans = k_scans, .rounds = {}, .independent_solutions = {}}});
    run_serially(plan, worker, {});
    const sampling::RoundStatistics& round = plan.ladders()[0].rounds()[0].statistics;
    const std::vector<double> log_steps = round.log_z_steps();
    for (std::size_t i = 0; i < steps.size(); ++i)
      steps[i].push_back(std::exp(log_steps[i]));
    inverse.push_back(std::exp(round.log_satisfied().value - round.log_z().value));
  }
  std::vector<double> p;
  for (std::size_t i = 0; i < steps.size(); ++i)
    p.push_back(mean_p(steps[i], z_of(ladder[i + 1]) / z_of(ladder[i])));
  p.push_back(mean_p(inverse, p_satisfied() / z_of(1)));
  return p;
}

/// Compares the mean weight of ascents with Z. The mean of weight times 1{satisfied} / p_c must
/// equal the probability that a prior draw satisfies the constraint.
std::vector<double> ascents_weigh(const Mutant& mutant, std::uint64_t seed) {
  Ring ring;
  ring.lies = mutant.lies;
  const run::ChainWorker<Ring> right(ring, {});
  const MutantWorker worker(mutant, right);
  sampling::AnnealedImportance part(burn_in_of(seed, 0), 1, 1);
  base::Bytes state;
  std::vector<double> satisfied;
  for (int ascent = 0; ascent < 40'000; ++ascent) {
    plan::UnitResult last;
    for (std::size_t step = 0; step < part.schedule().size(); ++step)
      last = go_on(part, worker, state);
    const plan::ScanRecord& end = last.scans.front();
    satisfied.push_back(end.satisfied ? std::exp(-end.log_constraint) : 0);
  }
  const std::vector<double> weights = exp_of_row(part, "log_weight");
  for (std::size_t i = 0; i < weights.size(); ++i)
    satisfied[i] *= weights[i];
  return {mean_p(weights, z_of(1)), mean_p(satisfied, p_satisfied())};
}

/// If scans are independent exact draws, simulated tempering is a random walk over levels. After
/// some scans, compares the frequencies of levels and places with enumeration. The weights are only
/// roughly right.
std::vector<double> levels_walk(const Mutant& mutant, std::uint64_t seed) {
  constexpr int k_moves = 6;
  const std::vector<double>& ladder = ladder_of_checks();
  const std::size_t levels = ladder.size();
  Ring ring;
  ring.lies = mutant.lies;
  const sampling::BurnIn some = burn_in_of(seed, 0);
  std::vector<double> log_weights{0};
  for (const double step : some.log_z_steps)
    log_weights.push_back(log_weights.back() - step);

  std::vector<double> at(levels, 0.0);
  at.back() = 1;
  for (int move = 0; move < k_moves; ++move) {
    std::vector<double> next = at;
    for (std::size_t from = 0; from < levels; ++from) {
      const std::vector<double> exact = RuggedRing::exact(ladder[from]);
      for (const std::size_t to : {from + 1, from - 1}) {
        if (to >= levels) continue;
        double rate = 0;
        for (std::size_t place = 0; place < k_places; ++place) {
          if (exact[place] == 0) continue;
          const double log_ratio =
              (ladder[to] - ladder[from]) * RuggedRing::k_log_constraint[place];
          rate += 0.5 * exact[place] *
                  std::min(1.0, std::exp(log_ratio + log_weights[to] - log_weights[from]));
        }
        next[to] += at[from] * rate;
        next[from] -= at[from] * rate;
      }
    }
    at = next;
  }
  std::vector<double> expected;
  for (std::size_t level = 0; level < levels; ++level) {
    for (const double x : RuggedRing::exact(ladder[level]))
      expected.push_back(at[level] * x);
  }

  std::vector<double> counts(expected.size(), 0.0);
  const ExactScans<Ring> exact(ring, seed);
  const MutantWorker worker(mutant, exact);
  for (std::uint32_t chain = 0; chain < 12'000; ++chain) {
    sampling::SimulatedTempering part(burn_in_of(seed, chain));
    base::Bytes state = ring.encode(0);
    plan::UnitResult result;
    for (int scan = 0; scan <= k_moves; ++scan)
      result = go_on(part, worker, state);
    const plan::ScanRecord& record = result.scans.front();
    const auto level = static_cast<std::size_t>(
        std::ranges::find(ladder, record.inverse_temperature) - ladder.begin());
    ++counts[level * k_places + static_cast<std::size_t>(record.outcome.front())];
  }
  return {chi_square_p(counts, expected)};
}

}  // namespace sleight::statistical
