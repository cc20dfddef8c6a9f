// Checks of a single chain: its steps, scans, random numbers and excursions.
#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/statistical/mutants/checks.h"
#include "tests/statistical/support/chi_square.h"
#include "worker/sampling/tempered_transition.h"

namespace sleight::statistical {
namespace {

sampling::ChainStreams streams_of(std::uint64_t seed, std::uint32_t chain) {
  return {.seed = seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}};
}

Ring ring_of(const Mutant& mutant) {
  Ring ring;
  ring.lies = mutant.lies;
  return ring;
}

std::uint32_t exact_place(const std::vector<double>& exact, std::uint64_t seed,
                          std::uint32_t chain) {
  return RuggedRing::pick(exact, streams_of(seed, chain).at(random::Purpose::start, 0).uniform());
}

void step(const Mutant& mutant, const Ring& ring, double beta,
          const sampling::ChainStreams& streams, std::uint64_t iteration,
          sampling::Sample<Ring>& sample) {
  if (mutant.step) {
    mutant.step(ring, beta, streams, iteration, sample);
  } else {
    sampling::metropolis_hastings_step(ring, beta, streams, iteration, sample);
  }
}

/// Enumerates the probabilities of a step from each place i to each place j.
std::vector<double> transitions(double beta) {
  const auto& prior = RuggedRing::k_prior;
  const std::vector<double> exact = RuggedRing::exact(beta);
  const double q = Ring::k_independent_share;
  std::vector<double> p(k_places * k_places, 0.0);
  for (std::size_t i = 0; i < k_places; ++i) {
    if (exact[i] == 0) continue;
    double leaves = 0;
    const auto leads = [&](std::size_t to, double proposed, double back) {
      if (to == i) return;
      const double flow = proposed * std::min(1.0, exact[to] * back / (exact[i] * proposed));
      p[i * k_places + to] += flow;
      leaves += flow;
    };
    for (std::size_t j = 0; j < k_places; ++j)
      leads(j, q * prior[j], q * prior[i]);
    const double on = (1 - q) * RuggedRing::k_clockwise;
    const double back = (1 - q) * (1 - RuggedRing::k_clockwise);
    leads((i + 1) % k_places, on, back);
    leads((i + k_places - 1) % k_places, back, on);
    p[i * k_places + i] = 1 - leaves;
  }
  return p;
}

/// Returns the joint probabilities of a place and the next place.
std::vector<double> joint_of(const std::vector<double>& places, std::vector<double> moves) {
  for (std::size_t i = 0; i < moves.size(); ++i)
    moves[i] *= places[i / k_places];
  return moves;
}

struct UnitPlace {
  std::uint32_t chain = 0;
  std::uint32_t replica = 0;
  std::uint64_t scan = 0;
};

plan::Unit unit_of(std::uint64_t seed, const UnitPlace& place, double beta) {
  plan::Unit unit;
  unit.seed = seed;
  unit.replica = {base::ChainId{place.chain}, base::ReplicaId{place.replica}};
  unit.first_scan = base::ScanIndex{place.scan};
  unit.scans = 1;
  unit.starts = place.scan == 0;
  unit.inverse_temperatures = {beta};
  return unit;
}

std::size_t place_of(const plan::UnitResult& result) {
  return static_cast<std::size_t>(result.scans.front().outcome.front());
}

}  // namespace

/// Moves exact draws by ten steps, and compares the states with enumeration.
std::vector<double> kernel_keeps(const Mutant& mutant, std::uint64_t seed) {
  const Ring ring = ring_of(mutant);
  std::vector<double> p;
  std::uint32_t chain = 0;
  for (const double beta : {1.0, 0.5}) {
    const std::vector<double> exact = RuggedRing::exact(beta);
    std::vector<double> counts(k_places, 0.0);
    for (int i = 0; i < 20'000; ++i, ++chain) {
      auto sample = sampling::evaluate(ring, exact_place(exact, seed, chain));
      for (std::uint64_t iteration = 1; iteration <= 10; ++iteration)
        step(mutant, ring, beta, streams_of(seed, chain), iteration, sample);
      ++counts[sample.state];
    }
    p.push_back(chi_square_p(counts, exact));
  }
  return p;
}

/// Makes two steps from exact draws. Compares pairs of states, before and after the second step,
/// with enumeration.
std::vector<double> kernel_moves(const Mutant& mutant, std::uint64_t seed) {
  constexpr double k_beta = 0.7;
  const Ring ring = ring_of(mutant);
  const std::vector<double> exact = RuggedRing::exact(k_beta);
  const std::vector<double> expected = joint_of(exact, transitions(k_beta));
  std::vector<double> counts(k_places * k_places, 0.0);
  for (std::uint32_t chain = 0; chain < 60'000; ++chain) {
    auto sample = sampling::evaluate(ring, exact_place(exact, seed, chain));
    step(mutant, ring, k_beta, streams_of(seed, chain), 1, sample);
    const std::size_t before = sample.state;
    step(mutant, ring, k_beta, streams_of(seed, chain), 2, sample);
    ++counts[before * k_places + sample.state];
  }
  return {chi_square_p(counts, expected)};
}

/// Runs six scans from exact draws. Compares the states after the last two scans with enumeration.
std::vector<double> scans_move(const Mutant& mutant, std::uint64_t seed) {
  const Ring ring = ring_of(mutant);
  const run::ChainWorker<Ring> right(ring, {});
  const MutantWorker worker(mutant, right);
  const std::vector<double> exact = RuggedRing::exact(1);
  const std::vector<double> expected = joint_of(exact, transitions(1));
  std::vector<double> counts(k_places * k_places, 0.0);
  for (std::uint32_t chain = 0; chain < 12'000; ++chain) {
    std::size_t place = exact_place(exact, seed, chain);
    std::size_t before = place;
    base::Bytes state = ring.encode(static_cast<std::uint32_t>(place));
    for (std::uint64_t scan = 1; scan <= 6; ++scan) {
      plan::UnitResult result = worker.run(unit_of(seed, {chain, 0, scan}, 1), state);
      state = std::move(result.state_after);
      before = std::exchange(place, place_of(result));
    }
    ++counts[before * k_places + place];
  }
  return {chi_square_p(counts, expected)};
}

/// Tests that prior draws are independent: those of two scans, of two replicas, and of two chains.
std::vector<double> draws_are_fresh(const Mutant& mutant, std::uint64_t seed) {
  const Ring ring = ring_of(mutant);
  const run::ChainWorker<Ring> right(ring, {});
  const MutantWorker worker(mutant, right);
  const std::vector<double> prior = RuggedRing::exact(0);
  std::vector<double> expected;
  for (const double a : prior) {
    for (const double b : prior)
      expected.push_back(a * b);
  }
  std::vector<std::vector<double>> counts(3, std::vector<double>(expected.size(), 0.0));
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    const plan::UnitResult first = worker.run(unit_of(seed, {2 * i, 0, 0}, 0), {});
    const plan::UnitResult others[3] = {
        worker.run(unit_of(seed, {2 * i, 0, 1}, 0), first.state_after),
        worker.run(unit_of(seed, {2 * i, 1, 0}, 0), {}),
        worker.run(unit_of(seed, {2 * i + 1, 0, 0}, 0), {})};
    for (std::size_t k = 0; k < 3; ++k)
      ++counts[k][place_of(first) * k_places + place_of(others[k])];
  }
  std::vector<double> p;
  for (const std::vector<double>& pairs : counts)
    p.push_back(chi_square_p(pairs, expected));
  return p;
}

/// Verifies that a unit's result doesn't depend on earlier units.
std::vector<double> results_are_pure(const Mutant& mutant, std::uint64_t seed) {
  const Ring ring = ring_of(mutant);
  const run::ChainWorker<Ring> right(ring, {});
  const MutantWorker worker(mutant, right);
  for (std::uint32_t chain = 0; chain < 100; ++chain) {
    base::Bytes state;
    for (std::uint64_t scan = 0; scan < 5; ++scan) {
      const plan::Unit unit = unit_of(seed, {chain, 0, scan}, 0.5);
      const plan::UnitResult once = worker.run(unit, state);
      const plan::UnitResult again = worker.run(unit, state);
      if (once.scans != again.scans || once.state_after != again.state_after) return {0};
      const std::uint32_t place = ring.decode(once.state_after).value();
      const plan::ScanRecord& record = once.scans.front();
      if (record.log_constraint != ring.log_constraint(place) ||
          record.log_prior != ring.log_prior(place))
        return {0};
      state = once.state_after;
    }
  }
  return {1};
}

/// Moves exact draws by three tempered transitions, and compares the states with enumeration.
std::vector<double> excursions_keep(const Mutant& mutant, std::uint64_t seed) {
  const Ring ring = ring_of(mutant);
  struct Way {
    double beta;
    std::vector<double> below;
  };
  std::vector<double> p;
  std::uint32_t chain = 0;
  for (const Way& way : {Way{1, {0.5, 0.2, 0}}, Way{0.8, {0.4, 0.1}}}) {
    const std::vector<double> exact = RuggedRing::exact(way.beta);
    std::vector<double> counts(k_places, 0.0);
    for (int i = 0; i < 12'000; ++i, ++chain) {
      auto sample = sampling::evaluate(ring, exact_place(exact, seed, chain));
      for (std::uint64_t scan = 1; scan <= 3; ++scan) {
        sampling::tempered_transition(ring,
                                      {.inverse_temperature = way.beta,
                                       .below = way.below,
                                       .steps = 1,
                                       .proposal_scales = {}},
                                      streams_of(seed, chain), scan, sample);
      }
      ++counts[sample.state];
    }
    p.push_back(chi_square_p(counts, exact));
  }
  return p;
}

/// Verifies that an excursion begins a lineage if it returns from the prior. If the state differs
/// from the result of plain steps, it has come from the prior.
std::vector<double> excursions_descend(const Mutant& mutant, std::uint64_t seed) {
  const Ring ring = ring_of(mutant);
  const run::ChainWorker<Ring> right(ring, {});
  const MutantWorker worker(mutant, right);
  const std::vector<double> exact = RuggedRing::exact(1);
  int came_back = 0;
  for (std::uint32_t chain = 0; chain < 1000; ++chain) {
    const base::Bytes state = ring.encode(exact_place(exact, seed, chain));
    plan::Unit unit = unit_of(seed, {chain, 0, 1}, 1);
    unit.lineage = 17;
    const plan::UnitResult plain = right.run(unit, state);
    unit.excursion = {0.5, 0.2, 0};
    const plan::UnitResult moved = worker.run(unit, state);
    const std::uint64_t fresh = plan::lineage_from(unit.replica.replica, 1);
    const std::uint64_t lineage = moved.scans.front().lineage;
    if (lineage != fresh && (lineage != 17 || moved.state_after != plain.state_after)) return {0};
    came_back += lineage == fresh ? 1 : 0;
  }
  // Require some excursions, because otherwise a worker that makes none would pass.
  return {came_back > 100 && came_back < 900 ? 1.0 : 0.0};
}

}  // namespace sleight::statistical
