// Runs units of plain and tempered chains of one world: the loop over scans and iterations, with
// states as bytes on both sides.
//
// Invariant: run is a pure function of (world parameters, options, unit, state before). What it
// costs is measured by whoever calls it.
#pragma once

#include <concepts>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/plan/unit.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/target.h"

namespace sleight::run {

/// A target whose states can travel and whose outcomes can be archived.
template <class W>
concept World = sampling::Target<W> &&
    requires(const W& world, const typename W::State& state, const typename W::Outcome& outcome,
             base::BytesView bytes) {
  { world.encode(state) } -> std::same_as<base::Bytes>;
  { world.decode(bytes) } -> std::same_as<std::optional<typename W::State>>;
  { world.outcome_values(outcome) } -> std::same_as<std::vector<double>>;
};

struct ChainWorkerOptions {
  std::uint64_t seed = 1;
  std::uint32_t iterations_per_scan = 1;
  std::uint64_t thin = 1;  ///< every thin-th scan's state is returned, besides the satisfied ones
};

template <World W>
class ChainWorker final : public plan::UnitWorker {
 public:
  ChainWorker(W world, const ChainWorkerOptions& options)
      : world_(std::move(world)), options_(options) {}

  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override {
    CHECK_GE(unit.scans, 1U);
    const sampling::ChainStreams streams{
        .seed = options_.seed, .chain = unit.replica.chain, .replica = unit.replica.replica};
    plan::UnitResult result{.unit = unit, .scans = {}, .state_after = {}};
    result.scans.reserve(unit.scans);

    // Begin at the prior draw, which is scan 0, or at the state before the unit.
    std::uint64_t scan = unit.first_scan.value;
    const std::uint64_t end = scan + unit.scans;
    sampling::Sample<W> current = begin(scan, streams, state);
    if (scan == 0) result.scans.push_back(record(scan++, current, {}));

    // Make the proposals of each scan.
    for (; scan < end; ++scan) {
      Counts counts(world_.proposal_kinds());
      const std::uint64_t first_iteration = (scan - 1) * options_.iterations_per_scan + 1;
      for (std::uint32_t i = 0; i < options_.iterations_per_scan; ++i) {
        counts.add(sampling::metropolis_hastings_step(world_, unit.inverse_temperature, streams,
                                                      first_iteration + i, current));
      }
      result.scans.push_back(record(scan, current, std::move(counts)));
    }
    result.state_after = world_.encode(current.state);
    return result;
  }

 private:
  struct Counts {
    Counts() = default;
    explicit Counts(std::uint32_t kinds) : proposed(kinds, 0), accepted(kinds, 0) {}
    void add(const sampling::StepReport& step) {
      ++proposed[step.kind];
      if (step.accepted) ++accepted[step.kind];
    }
    std::vector<std::uint32_t> proposed;
    std::vector<std::uint32_t> accepted;
  };

  sampling::Sample<W> begin(std::uint64_t first_scan, const sampling::ChainStreams& streams,
                            base::BytesView state) const {
    if (first_scan == 0) return sampling::initialize(world_, streams);
    std::optional<typename W::State> decoded = world_.decode(state);
    if (!decoded) {
      throw base::Error(
          "a chain's stored state can't be read: the run store is damaged; start over with "
          "--fresh");
    }
    return sampling::evaluate(world_, std::move(*decoded));
  }

  plan::ScanRecord record(std::uint64_t scan, const sampling::Sample<W>& sample,
                          Counts counts) const {
    if (counts.proposed.empty()) counts = Counts(world_.proposal_kinds());
    const bool satisfied = world_.satisfied(sample.outcome);
    const bool keep_state = satisfied || scan % options_.thin == 0;
    return {.log_prior = sample.log_prior,
            .log_constraint = sample.log_constraint,
            .satisfied = satisfied,
            .lineage = 0,
            .proposed = std::move(counts.proposed),
            .accepted = std::move(counts.accepted),
            .outcome = world_.outcome_values(sample.outcome),
            .state = keep_state ? world_.encode(sample.state) : base::Bytes{}};
  }

  W world_;
  ChainWorkerOptions options_;
};

}  // namespace sleight::run
