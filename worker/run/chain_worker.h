// Runs one world's units: scans of plain and tempered chains, and starts of a search. ChainWorker
// receives and returns states as bytes. Invariant: run is a pure function of (world parameters,
// options, unit, state before). Cached samples only save simulations. The caller measures the cost.
#pragma once

#include <concepts>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/plan/unit.h"
#include "worker/run/island_scan.h"
#include "worker/run/island_unit.h"
#include "worker/run/sample_cache.h"
#include "worker/run/scan_counts.h"
#include "worker/run/search_start.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/surrogate_transition.h"
#include "worker/sampling/target.h"
#include "worker/sampling/tempered_transition.h"

namespace sleight::run {

/// A target with states that can be encoded and outcomes that can be archived.
template <class W>
concept World = sampling::Target<W> &&
    requires(const W& world, const typename W::State& state, const typename W::Outcome& outcome,
             base::BytesView bytes) {
  { world.encode(state) } -> std::same_as<base::Bytes>;
  { world.decode(bytes) } -> std::same_as<std::optional<typename W::State>>;
  { world.outcome_values(outcome) } -> std::same_as<std::vector<double>>;
  // Upper bound, up to a few bytes, for the heap memory of a state and its outcome.
  { world.owned_bytes(state, outcome) } -> std::same_as<std::size_t>;
};

/// Below inverse temperature 1, the interval of stored states is this multiple of the request's
/// `thin`.
inline constexpr std::uint64_t k_hot_thin = 16;

struct ChainWorkerOptions {
  std::uint32_t iterations_per_scan = 1;
  /// From the first draw on, every `thin`-th scan returns its state. Satisfied states are always
  /// returned.
  std::uint64_t thin = 1;
  std::uint64_t first_draw = 0;
  /// Below inverse temperature 1, every `hot_thin`-th scan stores its state; 0: none does.
  std::uint64_t hot_thin = 0;
  /// Each scan ends with islands of this many particles (island_scan.h); 0: no islands.
  std::uint32_t particles = 0;
  /// Whether chains start from a search: all tours, or a ladder's first replicas.
  bool starts_by_search = false;
  /// A chain that relaxes a find ends with this scan; 0: finds are not relaxed. Only the last
  /// scan's state is returned; this state must also satisfy the constraint at rest.
  std::uint32_t relax_scans = 0;
  /// Whether records contain the values that judge a burn-in.
  bool is_judged = false;
  /// Memory for samples that wait for their replica's next unit; 0: none. Changes no result.
  std::size_t cache_bytes_max = k_cache_bytes_max;
};

/// A value that its first use makes.
template <class T>
class MadeOnce {
 public:
  template <class Make>
  const T& get(const Make& make) const {
    const std::scoped_lock lock(mutex_);
    if (!made_) made_ = make();
    return *made_;
  }

 private:
  mutable std::mutex mutex_{};
  mutable std::optional<T> made_{};
};

template <World W>
class ChainWorker final : public plan::UnitWorker {
 public:
  ChainWorker(W world, const ChainWorkerOptions& options)
      : world_(std::move(world)), options_(options), cache_(options.cache_bytes_max) {}

  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override {
    CHECK_GE(unit.scans, 1U);
    if (unit.searches()) return searched(unit);
    if (unit.draws_prior()) return drawn_from_prior(unit);
    if (unit.makes_islands()) return free_islands(unit);
    if (unit.starts)
      return go_on(unit, state.empty() ? std::nullopt : std::optional(evaluated(state)));
    std::optional<Sample> held = cache_.take(unit.replica, unit.first_scan.value);
    if (held) return go_on(unit, std::move(held));
    plan::UnitResult result = go_on(unit, evaluated(state));
    ++result.simulations;  // The simulation of the state before the unit.
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
    std::vector<double> method_values{};
  };
  using Counts = ScanCounts;

  static auto told(Walk& walk, Counts& counts) {
    return [&walk, &counts](const sampling::SimulationReport& report) {
      ++walk.simulations;
      counts.add(report);
    };
  }

  /// Returns the world's guide. The first call computes it.
  const auto& guide(std::uint64_t seed) const requires SearchedWorld<W> {
    return guide_.get([&] { return world_.learn(seed); });
  }

  plan::UnitResult searched(const plan::Unit& unit) const {
    if constexpr (SearchedWorld<W>) {
      // If chains use the guide, they report its failures; otherwise the first start does.
      const bool chains_tell = options_.particles > 0 || options_.starts_by_search;
      return search_unit(world_, guide(unit.seed), unit, !chains_tell);
    } else {
      base::check_failed("the world has a search", "");
    }
  }

  /// If a draw's simulation fails, the run doesn't fail. The draw gets log p_c = -infinity.
  plan::UnitResult drawn_from_prior(const plan::Unit& unit) const {
    plan::UnitResult result{
        .unit = unit, .scans = {}, .state_after = {}, .simulations = unit.scans};
    for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
      const std::uint64_t scan = unit.first_scan.value + nth;
      const Sample sample = sampling::evaluate(
          world_,
          sampling::nth_prior_draw(world_, plan::prior_draw_number(unit.replica.chain, scan)));
      result.scans.push_back({.log_prior = sample.log_prior,
                              .log_constraint = sample.log_constraint,
                              .satisfied = world_.satisfied(sample.outcome),
                              .lineage = scan,
                              .inverse_temperature = 0,
                              .outcome = world_.outcome_values(sample.outcome)});
    }
    return result;
  }

  /// Makes free islands and their draws. If an island has no draw, it gets one from the prior.
  plan::UnitResult free_islands(const plan::Unit& unit) const {
    if constexpr (StagedWorld<W>) {
      return staged_islands(world_, guide(unit.seed), options_.particles, unit);
    } else if constexpr (sampling::PassesStages<W>) {
      const FoundLevels& found =
          levels_.get([&] { return find_levels(world_, options_.particles, unit.seed); });
      return split_islands(world_, found, options_.particles, unit);
    } else {
      base::check_failed("the world has islands", "");
    }
  }

  /// Returns a start from islands or a search. Returns nothing if these fail, for a ladder's
  /// hottest replica, and for replicas that join later.
  std::optional<Sample> start_in_stages(Walk& walk, std::uint64_t scan, double beta,
                                        Counts& counts) const {
    const bool by_search =
        options_.starts_by_search && (options_.is_judged || (scan == 0 && beta > 0));
    if (options_.particles == 0 && !by_search) return std::nullopt;
    if constexpr (SearchedWorld<W>) {
      const auto& guide = this->guide(walk.streams.seed);
      const bool is_first = walk.streams.chain.value == 0 && scan == 0 && beta == 1;
      if (is_first) counts.add(world_.failures_of(guide));
      if constexpr (StagedWorld<W>)
        if (options_.particles > 0) return islands(walk, counts).start(scan);
      for (std::uint64_t nth = 0; nth < k_starts_max; ++nth) {
        sampling::SearchEffort effort;
        auto find = search_start(world_, guide, walk.streams, scan * k_starts_max + nth, effort);
        counts.add(effort.failures);
        counts.overlapping_starts += effort.overlapping_starts;
        walk.simulations += effort.simulations;
        if (find) return find;
      }
    }
    return std::nullopt;
  }

  auto islands(Walk& walk, Counts& counts) const requires StagedWorld<W> {
    return IslandScan<W>(world_, guide(walk.streams.seed), options_.particles, walk.streams,
                         told(walk, counts));
  }

  /// Makes the islands that end a scan.
  void visit_islands(Walk& walk, std::uint64_t scan, Counts& counts) const {
    if constexpr (StagedWorld<W>) {
      auto visit = islands(walk, counts).visit(scan, *std::move(walk.current));
      walk.current = std::move(visit.sample);
      walk.method_values = std::move(visit.method_values);
      if (visit.is_new) walk.lineage = plan::lineage_from(walk.streams.replica, scan);
    }
  }

  /// Begins a lineage from islands, from a search, or otherwise from the prior.
  void draw_afresh(Walk& walk, std::uint64_t scan, double beta, Counts& counts) const {
    walk.lineage = plan::lineage_from(walk.streams.replica, scan);
    walk.current = start_in_stages(walk, scan, beta, counts);
    if (!walk.current)
      walk.current = sampling::draw_afresh(world_, walk.streams, scan, told(walk, counts));
  }

  Sample evaluated(base::BytesView state) const {
    std::optional<typename W::State> decoded = world_.decode(state);
    if (!decoded) {
      throw base::Error(
          "can't read a chain's stored state, because the run store is damaged; start from scratch "
          "with --fresh");
    }
    Sample sample = sampling::evaluate(world_, std::move(*decoded));
    // A state whose simulation fails never becomes a sample. So this state's simulation once
    // succeeded.
    if (const auto report = sampling::report_of(world_, sample.outcome); report.failure)
      throw base::Error(base::ExitCode::bug, "a chain's stored state fails when simulated again: " +
                                                 report.failure->message);
    return sample;
  }

  /// Runs the unit from the sample `before`. If `before` is empty, the unit begins with a draw.
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
      walk.method_values.clear();
      // Make one scan. A replica's first scan is its given start or a draw.
      const bool is_first = unit.starts && nth == 0;
      if (is_first && walk.current) {
        walk.lineage = plan::lineage_from(unit.replica.replica, number);
      } else if (is_first || beta == 0) {
        draw_afresh(walk, number, beta, counts);
      } else {
        scan(walk, unit, number, beta, counts);
      }
      const bool satisfied = is_satisfied(number, *walk.current, counts);
      counts.tell_failed(number, result.failed);
      result.scans.push_back(record(number, beta, walk, satisfied, std::move(counts)));
    }
    result.state_after = world_.encode(walk.current->state);
    result.simulations = walk.simulations;
    const std::size_t bytes =
        sizeof(Sample) + world_.owned_bytes(walk.current->state, walk.current->outcome);
    cache_.put(unit.replica, first_scan + unit.scans, std::move(*walk.current), bytes);
    return result;
  }

  /// Makes the proposals, and an excursion if the unit has one. REQUIRES: beta > 0.
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
    if (options_.particles > 0) visit_islands(walk, scan, counts);
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

  /// Whether a scan's state satisfies the constraint. If this scan ends a find's relaxation, its
  /// state must also satisfy the constraint at rest.
  bool is_satisfied(std::uint64_t scan, const Sample& sample, Counts& counts) const {
    if (!world_.satisfied(sample.outcome)) return false;
    if constexpr (SearchedWorld<W>) {
      if (ends_relaxed(scan)) {
        const typename W::Outcome at_rest = world_.simulate_to_rest(sample.state);
        const auto report = sampling::report_of(world_, at_rest);
        counts.add(report);
        return !report.failure && world_.satisfied(at_rest);
      }
    }
    return true;
  }
  bool ends_relaxed(std::uint64_t scan) const {
    return options_.relax_scans > 0 && scan == options_.relax_scans;
  }

  plan::ScanRecord record(std::uint64_t scan, double beta, const Walk& walk, bool satisfied,
                          Counts counts) const {
    const Sample& sample = *walk.current;
    const bool is_thin =
        scan >= options_.first_draw && (scan - options_.first_draw) % options_.thin == 0;
    const bool is_hot_thin = options_.hot_thin > 0 && scan % options_.hot_thin == 0;
    const bool keep_state = options_.relax_scans > 0 ? ends_relaxed(scan) && satisfied
                            : beta == 1              ? satisfied || is_thin
                                                     : is_hot_thin;
    std::vector<double> method_values = walk.method_values;
    if constexpr (SearchedWorld<W>)
      if (options_.is_judged)
        method_values = world_.burn_in_values_of(sample.state, sample.outcome);
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
            .method_values = std::move(method_values),
            .state = keep_state ? world_.encode(sample.state) : base::Bytes{}};
  }

  template <class V>
  struct GuideOf {
    using type = int;
  };
  template <SearchedWorld V>
  struct GuideOf<V> {
    using type = typename V::Guide;
  };

  W world_;
  ChainWorkerOptions options_;
  MadeOnce<typename GuideOf<W>::type> guide_;
  MadeOnce<FoundLevels> levels_;
  mutable SampleCache<Sample> cache_;
};

}  // namespace sleight::run
