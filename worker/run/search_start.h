// Makes a search's starts (worker/sampling/stage_search.h), for a lane or for a chain.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/plan/failure.h"
#include "common/plan/unit.h"
#include "common/random/stream.h"
#include "worker/run/scan_counts.h"
#include "worker/sampling/burn_in_judge.h"
#include "worker/sampling/log_sum.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/stage_search.h"
#include "worker/sampling/stages.h"

namespace sleight::run {

/// A world that has a search. The guide depends only on the run's seed.
template <class W>
concept SearchedWorld = sampling::Target<W> &&
    requires(const W& world, std::uint64_t seed, const typename W::Guide& guide,
             const typename W::State& state, const typename W::Outcome& outcome) {
  { world.learn(seed) } -> std::same_as<typename W::Guide>;
  /// Failures of the simulations that computed the guide.
  { world.failures_of(guide) } -> std::convertible_to<std::span<const plan::FailurePointer>>;
  requires sampling::StageBuilder<decltype(world.builder(guide))>;
  /// Outcome of the whole motion, until rest. A find's outcome at rest must satisfy the constraint
  /// too.
  { world.simulate_to_rest(state) } -> std::same_as<typename W::Outcome>;
  /// burn_in_values() lists the values that judge the burn-in of chains from a search
  /// (burn_in_judge.h). burn_in_values_of() returns their numbers for a state.
  { world.burn_in_values() } -> std::same_as<std::vector<sampling::BurnInValue>>;
  { world.burn_in_values_of(state, outcome) } -> std::same_as<std::vector<double>>;
  { world.stages() } -> std::same_as<std::uint32_t>;
  /// Name for display, such as "ball 3 of 16". If the builder reports misses, the world also has
  /// miss_kinds(), a std::vector<sampling::MissKind>. It may have search_advice(), a sentence that
  /// says what to do if a search gives up.
  { world.stage_name(std::uint32_t{}) } -> std::same_as<std::string>;
};

/// A world that also has islands.
template <class W>
concept StagedWorld = SearchedWorld<W> && sampling::ActsInStages<W>;

/// Maximum number of starts of one chain at one scan.
inline constexpr std::uint64_t k_starts_max = 256;

/// Makes the `number`-th search of a lane or chain. Returns the find, or nothing if the search gave
/// up or the state fails at rest.
template <SearchedWorld W>
std::optional<sampling::Sample<W>> search_start(const W& world, const typename W::Guide& guide,
                                                const sampling::ChainStreams& streams,
                                                std::uint64_t number,
                                                sampling::SearchEffort& effort) {
  random::Stream stream = streams.at(random::Purpose::search, number);
  const auto builder = world.builder(guide);
  const auto prefix = sampling::search(builder, builder.limits(), stream, effort);
  if (!prefix) return std::nullopt;
  typename W::State state = builder.state_of(*prefix);
  ++effort.simulations;
  const typename W::Outcome at_rest = world.simulate_to_rest(state);
  if (const auto failure = sampling::report_of(world, at_rest).failure) {
    effort.failures.push_back(failure);
    return std::nullopt;
  }
  if (!world.satisfied(at_rest)) return std::nullopt;
  typename W::Outcome outcome = builder.outcome_of(*prefix);
  const double log_prior = world.log_prior(state);
  const double log_constraint = world.log_constraint(outcome);
  return sampling::Sample<W>{std::move(state), std::move(outcome), log_prior, log_constraint};
}

/// Returns a start's record. If there is no find, `method_values` has the maximum number of
/// accepted stages, and the kind and amount of the nearest miss of the next stage, if one is known.
template <SearchedWorld W>
plan::ScanRecord start_record(const W& world, const std::optional<sampling::Sample<W>>& find,
                              std::uint64_t scan, const sampling::SearchEffort& effort,
                              const ScanCounts& counts) {
  plan::ScanRecord record{.log_prior = sampling::k_log_zero,
                          .log_constraint = sampling::k_log_zero,
                          .lineage = scan,
                          .failures = counts.failures,
                          .overlapping_starts = counts.overlapping_starts};
  if (!find) {
    record.method_values = {static_cast<double>(effort.furthest)};
    if (const auto& nearest = effort.nearest)
      record.method_values.insert(record.method_values.end(),
                                  {static_cast<double>(nearest->kind), nearest->amount});
    return record;
  }
  record.log_prior = find->log_prior;
  record.log_constraint = find->log_constraint;
  record.satisfied = true;
  record.outcome = world.outcome_values(find->outcome);
  record.state = world.encode(find->state);
  return record;
}

/// Makes a lane's starts, one per scan. If `tells_guide` is set, start 0 reports the guide's
/// failures. REQUIRES: unit.searches().
template <SearchedWorld W>
plan::UnitResult search_unit(const W& world, const typename W::Guide& guide, const plan::Unit& unit,
                             bool tells_guide) {
  plan::UnitResult result{.unit = unit, .scans = {}, .state_after = {}};
  const sampling::ChainStreams streams{
      .seed = unit.seed, .chain = unit.replica.chain, .replica = unit.replica.replica};
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
    const std::uint64_t scan = unit.first_scan.value + nth;
    sampling::SearchEffort effort;
    const auto find = search_start(world, guide, streams, scan, effort);
    ScanCounts counts(0);
    if (tells_guide && plan::start_number(unit.replica.chain, scan) == 0)
      counts.add(world.failures_of(guide));
    counts.add(effort.failures);
    counts.overlapping_starts = effort.overlapping_starts;
    counts.tell_failed(scan, result.failed);
    result.simulations += effort.simulations + effort.guesses;
    result.scans.push_back(start_record(world, find, scan, effort, counts));
  }
  return result;
}

}  // namespace sleight::run
