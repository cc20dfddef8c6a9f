// Checks of parallel tempering.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/statistical/mutants/checks.h"
#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/run_serially.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"

namespace sleight::statistical {
namespace {

sampling::ParallelTemperingOptions fixed(std::uint64_t seed, std::uint64_t round_scans,
                                         std::uint64_t scans) {
  return {.ladders = 1,
          .ladder = {.seed = seed,
                     .chain = {},
                     .first_ladder = ladder_of_checks(),
                     .levels_chosen = false,
                     .levels_max = 64,
                     .ladder_adapts = false,
                     .has_scale = {},
                     .round_scans = round_scans,
                     .anneal_scans = 0},
          .stop = {.scans = scans, .rounds = {}, .independent_solutions = {}}};
}

sampling::ParallelTemperingOptions learning(std::uint64_t seed, std::uint64_t round_scans,
                                            std::uint64_t rounds) {
  sampling::ParallelTemperingOptions options =
      fixed(seed, round_scans, round_scans * ((std::uint64_t{1} << rounds) - 1));
  options.ladder.first_ladder = sampling::first_ladder(5);
  options.ladder.levels_chosen = true;
  options.ladder.ladder_adapts = true;
  options.ladder.levels_max = 16;
  options.ladder.has_scale = {true, true};
  return options;
}

std::size_t level_of(double beta) {
  const std::vector<double>& ladder = ladder_of_checks();
  return static_cast<std::size_t>(std::ranges::find(ladder, beta) - ladder.begin());
}

/// Enumerates the probability that levels i and i+1 swap in equilibrium.
double swap_rate(std::size_t i) {
  const std::vector<double> here = RuggedRing::exact(ladder_of_checks()[i]);
  const std::vector<double> cooler = RuggedRing::exact(ladder_of_checks()[i + 1]);
  double sum = 0;
  for (std::size_t a = 0; a < k_places; ++a) {
    for (std::size_t b = 0; b < k_places; ++b)
      sum += std::min(here[a] * cooler[b], here[b] * cooler[a]);
  }
  return sum;
}

}  // namespace

/// Starts ladders from exact draws, and makes ten scans, which include a round's end. Compares the
/// levels with enumeration. Neighbouring levels must be independent and have their distributions,
/// and rejection rates must be right.
std::vector<double> ladder_keeps(const Mutant& mutant, std::uint64_t seed) {
  constexpr std::uint64_t k_last = 9;
  const std::size_t levels = ladder_of_checks().size();
  Ring ring;
  ring.independent_share = 0;
  ring.lies = mutant.lies;
  std::vector<std::vector<double>> pairs(levels - 1, std::vector<double>(k_places * k_places, 0.0));
  std::vector<std::vector<double>> rejections(levels - 1);
  for (std::uint64_t n = 0; n < 6000; ++n) {
    const std::uint64_t own = seed_of(seed, n);
    const run::ChainWorker<Ring> chain_worker(ring, {});
    const ExactStarts<Ring> from_exact(ring, own, chain_worker);
    const MutantWorker worker(mutant, from_exact);
    sampling::ParallelTempering right(fixed(own, 4, k_last + 1));
    MutantPlan plan(mutant, right);
    std::vector<std::size_t> places(levels);
    run_serially(plan, worker, [&](const plan::UnitResult& result) {
      if (result.unit.first_scan.value != k_last) return;
      const plan::ScanRecord& record = result.scans.front();
      places[level_of(record.inverse_temperature)] =
          static_cast<std::size_t>(record.outcome.front());
    });
    for (std::size_t i = 0; i + 1 < levels; ++i)
      ++pairs[i][places[i] * k_places + places[i + 1]];
    const std::vector<double> rates = right.ladders()[0].rounds()[0].statistics.rejections();
    for (std::size_t i = 0; i < rates.size(); ++i)
      rejections[i].push_back(rates[i]);
  }
  std::vector<double> p;
  for (std::size_t i = 0; i + 1 < levels; ++i) {
    const std::vector<double> here = RuggedRing::exact(ladder_of_checks()[i]);
    const std::vector<double> cooler = RuggedRing::exact(ladder_of_checks()[i + 1]);
    std::vector<double> joint;
    for (const double a : here) {
      for (const double b : cooler)
        joint.push_back(a * b);
    }
    p.push_back(chi_square_p(pairs[i], joint));
    p.push_back(mean_p(rejections[i], 1 - swap_rate(i)));
  }
  return p;
}

/// If scans are independent exact draws, each replica is a random walk. Compares early and late
/// levels of the hottest and the coolest replica with the walk's probabilities.
std::vector<double> replicas_travel(const Mutant& mutant, std::uint64_t seed) {
  constexpr std::uint64_t k_early = 2;
  constexpr std::uint64_t k_late = 5;
  const std::size_t levels = ladder_of_checks().size();
  Ring ring;
  ring.lies = mutant.lies;
  std::vector<double> rates;
  for (std::size_t i = 0; i + 1 < levels; ++i)
    rates.push_back(swap_rate(i));
  // A replica is at level `from` at `scan`. Returns the probability of each level at scan `until`.
  const auto walk = [&](std::size_t from, std::uint64_t scan, std::uint64_t until) {
    std::vector<double> at(levels, 0.0);
    at[from] = 1;
    for (; scan < until; ++scan) {
      for (std::size_t i = scan % 2; i + 1 < levels; i += 2) {
        const double flow = rates[i] * (at[i + 1] - at[i]);
        at[i] += flow;
        at[i + 1] -= flow;
      }
    }
    return at;
  };
  const auto expected = [&](std::size_t replica) {
    std::vector<double> joint;
    const std::vector<double> early = walk(replica, 0, k_early);
    for (std::size_t level = 0; level < levels; ++level) {
      for (const double late : walk(level, k_early, k_late))
        joint.push_back(early[level] * late);
    }
    return joint;
  };
  std::vector<std::vector<double>> counts(levels, std::vector<double>(levels * levels, 0.0));
  for (std::uint64_t n = 0; n < 4000; ++n) {
    const std::uint64_t own = seed_of(seed, n);
    const ExactScans<Ring> exact(ring, own);
    const MutantWorker worker(mutant, exact);
    sampling::ParallelTempering right(fixed(own, 64, k_late + 1));
    MutantPlan plan(mutant, right);
    std::vector<std::size_t> early(levels, 0);
    run_serially(plan, worker, [&](const plan::UnitResult& result) {
      const std::uint64_t scan = result.unit.first_scan.value;
      const std::size_t replica = result.unit.replica.replica.value;
      const std::size_t level = level_of(result.unit.inverse_temperature(0));
      if (scan == k_early) early[replica] = level;
      if (scan == k_late) ++counts[replica][early[replica] * levels + level];
    });
  }
  return {chi_square_p(counts.front(), expected(0)),
          chi_square_p(counts.back(), expected(levels - 1))};
}

/// Verifies that adapting ladders find the weights of the ring's three parts, although no step
/// connects the parts. Ladders start from prior draws. Compares the shares of two parts in the last
/// round.
std::vector<double> parts_are_found(const Mutant& mutant, std::uint64_t seed) {
  constexpr std::uint64_t k_round_scans = 16;
  constexpr std::uint64_t k_rounds = 4;
  constexpr std::uint64_t k_from = k_round_scans * ((1U << (k_rounds - 1)) - 1);
  const auto part_of = [](std::size_t place) {
    return place < 3 || place > 12 ? std::size_t{0} : place < 8 ? std::size_t{1} : std::size_t{2};
  };
  Ring ring;
  ring.independent_share = 0;
  ring.lies = mutant.lies;
  std::vector<std::vector<double>> shares(3);
  for (std::uint64_t n = 0; n < 600; ++n) {
    const std::uint64_t own = seed_of(seed, n);
    const run::ChainWorker<Ring> chain_worker(ring, {});
    const MutantWorker worker(mutant, chain_worker);
    sampling::ParallelTempering right(learning(own, k_round_scans, k_rounds));
    MutantPlan plan(mutant, right);
    std::vector<double> counts(3, 0.0);
    run_serially(plan, worker, [&](const plan::UnitResult& result) {
      const plan::ScanRecord& record = result.scans.front();
      if (record.inverse_temperature != 1 || result.unit.first_scan.value < k_from) return;
      ++counts[part_of(static_cast<std::size_t>(record.outcome.front()))];
    });
    for (std::size_t part = 0; part < 3; ++part)
      shares[part].push_back(counts[part] / (k_round_scans << (k_rounds - 1)));
  }
  std::vector<double> exact(3, 0.0);
  const std::vector<double> places = RuggedRing::exact(1);
  for (std::size_t place = 0; place < k_places; ++place)
    exact[part_of(place)] += places[place];
  return {mean_p(shares[0], exact[0]), mean_p(shares[2], exact[2])};
}

/// Like parts_are_found(), but the world has two narrow modes on a line, and proposal scales adapt.
std::vector<double> modes_are_found(const Mutant& mutant, std::uint64_t seed) {
  constexpr std::uint64_t k_round_scans = 32;
  constexpr std::uint64_t k_rounds = 5;
  constexpr std::uint64_t k_from = k_round_scans * ((1U << (k_rounds - 1)) - 1);
  TwoModes world;
  world.prior_sd = 4;
  std::vector<double> shares;
  for (std::uint64_t n = 0; n < 150; ++n) {
    const std::uint64_t own = seed_of(seed, n);
    const run::ChainWorker<TwoModes> chain_worker(world, {});
    const MutantWorker worker(mutant, chain_worker);
    sampling::ParallelTempering right(learning(own, k_round_scans, k_rounds));
    MutantPlan plan(mutant, right);
    double left = 0;
    run_serially(plan, worker, [&](const plan::UnitResult& result) {
      const plan::ScanRecord& record = result.scans.front();
      if (record.inverse_temperature != 1 || result.unit.first_scan.value < k_from) return;
      left += record.outcome.front() < 0 ? 1 : 0;
    });
    shares.push_back(left / (k_round_scans << (k_rounds - 1)));
  }
  return {mean_p(shares, world.left_weight())};
}

/// Counts lineages and solutions from records. A lineage must begin at each prior draw and nowhere
/// else. A lineage must travel with its replica and have at most one solution.
std::vector<double> lineages_are_right(const Mutant& mutant, std::uint64_t seed) {
  const Ring ring;
  const run::ChainWorker<Ring> chain_worker(ring, {});
  const MutantWorker worker(mutant, chain_worker);
  sampling::ParallelTempering right(learning(seed, 16, 4));
  MutantPlan plan(mutant, right);
  std::uint64_t begun = 0;
  bool all_right = true;
  std::map<plan::ReplicaKey, std::uint64_t> visits;
  std::map<std::uint64_t, std::uint64_t> names;
  std::set<std::uint64_t> solved;
  run_serially(plan, worker, [&](const plan::UnitResult& result) {
    const plan::ScanRecord& record = result.scans.front();
    std::uint64_t& visit = visits[result.unit.replica];
    if (result.unit.starts || record.inverse_temperature == 0) visit = ++begun;
    const auto known = names.emplace(record.lineage, visit).first;
    all_right = all_right && known->second == visit;
    if (record.satisfied && record.inverse_temperature == 1) solved.insert(visit);
  });
  return {all_right && names.size() == begun && solved.size() == right.solutions_found() ? 1.0 : 0};
}

/// Verifies that inverse temperatures and proposal scales of levels stay the same within a round.
std::vector<double> rounds_are_frozen(const Mutant& mutant, std::uint64_t seed) {
  const Ring ring;
  const run::ChainWorker<Ring> chain_worker(ring, {});
  const MutantWorker worker(mutant, chain_worker);
  sampling::ParallelTempering right(learning(seed, 64, 3));
  MutantPlan plan(mutant, right);
  std::vector<plan::Unit> units;
  run_serially(plan, worker, [&](const plan::UnitResult& result) { units.push_back(result.unit); });
  const std::vector<sampling::RoundReport>& rounds = right.ladders()[0].rounds();
  for (const plan::Unit& unit : units) {
    const auto after = std::ranges::upper_bound(rounds, unit.first_scan.value, {},
                                                &sampling::RoundReport::first_scan);
    const sampling::RoundReport& round = *std::prev(after);
    const std::vector<double>& ladder = round.statistics.ladder();
    const auto level = std::ranges::find(ladder, unit.inverse_temperature(0));
    if (level == ladder.end()) return {0};
    if (unit.proposal_scales != round.scales[static_cast<std::size_t>(level - ladder.begin())])
      return {0};
  }
  return {1};
}

}  // namespace sleight::statistical
