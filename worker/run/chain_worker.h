// Runs units of plain and tempered chains of one world: the loop over scans and iterations, with
// states as bytes on both sides.
//
// Invariant: run is a pure function of (world parameters, options, unit, state before); samples
// that it keeps spare simulations only. The caller measures the cost.
#pragma once

#include <concepts>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/plan/unit.h"
#include "worker/run/sample_cache.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/surrogate_transition.h"
#include "worker/sampling/target.h"
#include "worker/sampling/tempered_transition.h"

namespace sleight::run {

/// A target whose states can travel and whose outcomes can be archived.
template <class W>
concept World = sampling::Target<W> &&
    requires(const W& world, const typename W::State& state, const typename W::Outcome& outcome,
             base::BytesView bytes) {
  { world.encode(state) } -> std::same_as<base::Bytes>;
  { world.decode(bytes) } -> std::same_as<std::optional<typename W::State>>;
  { world.outcome_values(outcome) } -> std::same_as<std::vector<double>>;
  // What a state and its outcome own outside of themselves: a bound for all but a few bytes.
  { world.owned_bytes(state, outcome) } -> std::same_as<std::size_t>;
};

/// Hot replicas' states are there to be looked at now and then.
inline constexpr std::uint64_t k_hot_thin = 16;

struct ChainWorkerOptions {
  std::uint32_t iterations_per_scan = 1;
  /// Every thin-th scan's state is returned, counted from the first draw, besides the satisfied
  /// ones.
  std::uint64_t thin = 1;
  std::uint64_t first_draw = 0;
  /// Of scans below inverse temperature 1 every so many-th; 0: none.
  std::uint64_t hot_thin = 0;
  /// Of samples held for their replicas' next units; 0: none are. Changes no result.
  std::size_t cache_bytes_max = k_cache_bytes_max;
};

template <World W>
class ChainWorker final : public plan::UnitWorker {
 public:
  ChainWorker(W world, const ChainWorkerOptions& options)
      : world_(std::move(world)), options_(options), cache_(options.cache_bytes_max) {}

  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override {
    CHECK_GE(unit.scans, 1U);
    if (unit.starts) return go_on(unit, {});
    std::optional<Sample> held = cache_.take(unit.replica, unit.first_scan.value);
    if (held) return go_on(unit, std::move(held));
    plan::UnitResult result = go_on(unit, evaluated(state));
    ++result.simulations;  // of the state before it
    return result;
  }

  std::optional<plan::UnitResult> run_from_held(const plan::Unit& unit) const override {
    CHECK(!unit.starts && unit.scans >= 1);
    std::optional<Sample> held = cache_.take(unit.replica, unit.first_scan.value);
    if (!held) return std::nullopt;
    return go_on(unit, std::move(held));
  }

  bool holds(const plan::Unit& unit) const override {
    CHECK(!unit.starts);
    return cache_.holds(unit.replica, unit.first_scan.value);
  }

  plan::CacheUse cache_use() const override { return cache_.use(); }

 private:
  using Sample = sampling::Sample<W>;
  struct Walk {
    sampling::ChainStreams streams;
    std::optional<Sample> current;
    std::uint64_t lineage = 0;
    std::uint64_t simulations = 0;
  };
  /// What happened in a scan.
  struct Counts {
    explicit Counts(std::uint32_t kinds) : proposed(kinds, 0), accepted(kinds, 0) {}
    void add(const sampling::StepReport& step) {
      ++proposed[step.kind];
      if (step.accepted) ++accepted[step.kind];
      add(step.simulation);
    }
    void add(const sampling::SimulationReport& report) {
      if (report.starts_overlap) ++overlapping_starts;
      if (report.failure == nullptr) return;
      failures.add(report.failure->kind);
      if (failed.size() < plan::k_failed_told_max) failed.push_back(report.failure);
    }
    std::vector<std::uint32_t> proposed;
    std::vector<std::uint32_t> accepted;
    std::uint64_t overlapping_starts = 0;
    plan::FailureCounts failures;
    std::vector<plan::FailurePointer> failed;
  };

  void draw_afresh(Walk& walk, std::uint64_t scan, base::ReplicaId replica, Counts& counts) const {
    walk.current = sampling::draw_afresh(world_, walk.streams, scan,
                                         [&](const sampling::SimulationReport& report) {
                                           ++walk.simulations;
                                           counts.add(report);
                                         });
    walk.lineage = plan::lineage_from(replica, scan);
  }

  Sample evaluated(base::BytesView state) const {
    std::optional<typename W::State> decoded = world_.decode(state);
    if (!decoded) {
      throw base::Error(
          "a chain's stored state can't be read: the run store is damaged; start over with "
          "--fresh");
    }
    Sample sample = sampling::evaluate(world_, std::move(*decoded));
    // A failure is never a sample, so this one once succeeded.
    if (const auto report = sampling::report_of(world_, sample.outcome); report.failure)
      throw base::Error(base::ExitCode::bug,
                        "a chain's stored state fails when it is simulated "
                        "again: " +
                            report.failure->message);
    return sample;
  }

  /// The unit from the sample before it; none if the unit starts with a prior draw.
  plan::UnitResult go_on(const plan::Unit& unit, std::optional<Sample> before) const {
    plan::UnitResult result{.unit = unit, .scans = {}, .state_after = {}};
    result.scans.reserve(unit.scans);
    Walk walk{.streams = {.seed = unit.seed,
                          .chain = unit.replica.chain,
                          .replica = unit.replica.replica},
              .current = std::move(before),
              .lineage = unit.lineage,
              .simulations = 0};
    const std::uint64_t first_scan = unit.first_scan.value;
    for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
      const double beta = unit.inverse_temperature(nth);
      const std::uint64_t number = first_scan + nth;
      Counts counts(world_.proposal_kinds());
      // One scan: a draw from the prior where it is the replica's first, or nothing constrains.
      if ((unit.starts && nth == 0) || beta == 0) {
        draw_afresh(walk, number, unit.replica.replica, counts);
      } else {
        scan(walk, unit, number, beta, counts);
      }
      tell_failed(number, counts, result.failed);
      result.scans.push_back(record(number, beta, walk, std::move(counts)));
    }
    result.state_after = world_.encode(walk.current->state);
    result.simulations = walk.simulations;
    const std::size_t bytes =
        sizeof(Sample) + world_.owned_bytes(walk.current->state, walk.current->outcome);
    cache_.put(unit.replica, first_scan + unit.scans, std::move(*walk.current), bytes);
    return result;
  }

  static void tell_failed(std::uint64_t scan, const Counts& counts,
                          std::vector<plan::FailedSimulation>& failed) {
    for (const plan::FailurePointer& failure : counts.failed) {
      if (failed.size() == plan::k_failed_told_max) return;
      failed.push_back({.scan = base::ScanIndex{scan}, .failure = *failure});
    }
  }

  /// Proposals, and an excursion if the unit has one. REQUIRES: an inverse temperature above 0.
  void scan(Walk& walk, const plan::Unit& unit, std::uint64_t scan, double beta,
            Counts& counts) const {
    const std::uint64_t first_iteration = (scan - 1) * options_.iterations_per_scan + 1;
    for (std::uint32_t i = 0; i < options_.iterations_per_scan; ++i) {
      sampling::iterate(world_, beta, walk.streams, first_iteration + i, *walk.current,
                        unit.proposal_scales, [&](const sampling::StepReport& step) {
                          counts.add(step);
                          walk.simulations += step.simulated ? 1 : 0;
                        });
    }
    if (unit.excursion.empty()) return;
    const sampling::ExcursionReport report = sampling::tempered_transition(
        world_,
        {.inverse_temperature = beta,
         .below = unit.excursion,
         .steps = options_.iterations_per_scan,
         .proposal_scales = unit.proposal_scales},
        walk.streams, scan, *walk.current,
        [&](const sampling::SimulationReport& simulation) { counts.add(simulation); });
    walk.simulations += report.simulations;
    if (report.from_prior) walk.lineage = plan::lineage_from(unit.replica.replica, scan);
  }

  plan::ScanRecord record(std::uint64_t scan, double beta, const Walk& walk, Counts counts) const {
    const Sample& sample = *walk.current;
    const bool satisfied = world_.satisfied(sample.outcome);
    const bool is_thin =
        scan >= options_.first_draw && (scan - options_.first_draw) % options_.thin == 0;
    const bool is_hot_thin = options_.hot_thin > 0 && scan % options_.hot_thin == 0;
    const bool keep_state = beta == 1 ? satisfied || is_thin : is_hot_thin;
    return {.log_prior = sample.log_prior,
            .log_constraint = sample.log_constraint,
            .satisfied = satisfied,
            .lineage = walk.lineage,
            .inverse_temperature = beta,
            .proposed = std::move(counts.proposed),
            .accepted = std::move(counts.accepted),
            .outcome = world_.outcome_values(sample.outcome),
            .failures = counts.failures,
            .overlapping_starts = counts.overlapping_starts,
            .state = keep_state ? world_.encode(sample.state) : base::Bytes{}};
  }

  W world_;
  ChainWorkerOptions options_;
  mutable SampleCache<Sample> cache_;
};

}  // namespace sleight::run
