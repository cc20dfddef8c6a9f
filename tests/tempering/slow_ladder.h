// Parallel tempering by its plain loop (tests/tempering/tempering_loop.h). SlowLadder is the
// reference for LadderRun and block runners. SlowLadder counts round trips and solutions from whole
// paths. The real code shares only the adaptation between rounds; ladder_round_test.cpp verifies
// this adaptation.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "common/plan/unit.h"
#include "worker/sampling/ladder_run.h"

namespace sleight::sampling {

/// A worker whose results depend on the state before the unit, and on all fields of the unit except
/// its seed. So a single wrong unit changes all later results.
class HashedWorker final : public plan::UnitWorker {
 public:
  struct Options {
    std::uint64_t seed = 1;
    /// log_constraint is in (-roughness, 0). Each block of 32 scans has a roughness from this list.
    std::vector<double> roughness{1};
    double broken = 0;     ///< Probability that log_constraint is -infinity.
    double satisfied = 0;  ///< Probability that a scan is satisfied.
  };
  explicit HashedWorker(Options options) : options_(std::move(options)) {}
  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override;

 private:
  Options options_;
};

struct SlowLadder {
  std::vector<RoundReport> rounds;       ///< The current round last, as in LadderRun.
  std::vector<std::uint64_t> solutions;  ///< By round, the current one last.
  using Place = std::pair<std::uint32_t, std::uint64_t>;  ///< (replica, scan).
  std::map<Place, plan::Unit> units;
  std::map<Place, plan::UnitResult> results;
};

/// Runs `scans` scans, annealing included.
SlowLadder slow_ladder(const LadderOptions& options, const plan::UnitWorker& worker,
                       std::uint64_t scans);

/// Returns the bits of all numbers in the rounds.
std::vector<std::uint64_t> fingerprint(std::span<const RoundReport> rounds,
                                       std::span<const std::uint64_t> solutions);

}  // namespace sleight::sampling
