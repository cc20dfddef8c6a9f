// Parallel tempering as its loop says it (tests/tempering/tempering_loop.h), run with a worker, so
// that LadderRun and block runners can be held against it: what was asked for and what came of it
// is kept by place. Round trips and solutions are counted here, from whole ways. What is learnt at
// a round's end is the one thing that both share; ladder_round_test.cpp works it out by hand.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "common/plan/unit.h"
#include "worker/sampling/ladder_run.h"

namespace sleight::sampling {

/// A worker whose results hang on all that a unit says but its seed, and on the state before it:
/// what is handed out wrongly once is different for ever.
class HashedWorker final : public plan::UnitWorker {
 public:
  struct Options {
    std::uint64_t seed = 1;
    /// log_constraint lies in (-roughness, 0), the roughness of every 32 scans drawn from these.
    std::vector<double> roughness{1};
    double broken = 0;     ///< how often log_constraint is -infinity
    double satisfied = 0;  ///< how often a scan is satisfied
  };
  explicit HashedWorker(Options options) : options_(std::move(options)) {}
  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override;

 private:
  Options options_;
};

struct SlowLadder {
  std::vector<RoundReport> rounds;       ///< the present one last, as LadderRun has them
  std::vector<std::uint64_t> solutions;  ///< likewise
  using Place = std::pair<std::uint32_t, std::uint64_t>;  ///< replica, scan
  std::map<Place, plan::Unit> units;
  std::map<Place, plan::UnitResult> results;
};

/// So many scans of it, those that anneal included.
SlowLadder slow_ladder(const LadderOptions& options, const plan::UnitWorker& worker,
                       std::uint64_t scans);

/// All that rounds say, bit for bit.
std::vector<std::uint64_t> fingerprint(std::span<const RoundReport> rounds,
                                       std::span<const std::uint64_t> solutions);

}  // namespace sleight::sampling
