// A worker that computes a hash chain (HashedWorker) scan by scan. Each scan has a fixed cost. Like
// a real worker process, the worker holds a bounded number of states by replica and version.
//
// Costs are log-uniform over a factor of k_cost_spread. Running a unit advances the given clock by
// its cost, so a block runner measures exactly this cost. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "common/base/clock.h"
#include "tests/cluster/mistakes.h"
#include "tests/tempering/slow_ladder.h"
#include "worker/run/sample_cache.h"

namespace sleight::cluster {

/// Sebastiano Vigna's splitmix64.
std::uint64_t mixed(std::uint64_t a, std::uint64_t b);

inline constexpr double k_cost_spread = 100;

/// Costs of scans. A scan's cost doesn't depend on the worker or the time.
struct Costs {
  std::uint64_t seed = 1;
  double least_s = 1e-4;
  double of(const plan::ReplicaKey& replica, std::uint64_t scan) const;
  /// Mean cost of a scan.
  double mean_s() const;
};

struct HashWorkerOptions {
  sampling::HashedWorker::Options hash;
  Costs costs;
  std::size_t states_held_bytes = 0;
  std::uint64_t id = 0;  ///< of the worker; results don't depend on it
  Mistake mistake = Mistake::none;
};

class HashWorker final : public plan::UnitWorker {
 public:
  /// Borrows the clock.
  HashWorker(const HashWorkerOptions& options, base::ManualClock& clock);

  plan::UnitResult run(const plan::Unit& unit, base::BytesView state) const override;
  std::optional<plan::UnitResult> run_from_held(const plan::Unit& unit) const override;
  bool holds(const plan::Unit& unit) const override;
  plan::CacheUse cache_use() const override { return held_.use(); }

 private:
  plan::UnitResult go_on(const plan::Unit& unit, base::Bytes state) const;
  std::optional<base::Bytes> take(const plan::Unit& unit) const;

  HashWorkerOptions options_;
  sampling::HashedWorker hashed_;
  base::ManualClock& clock_;
  mutable run::SampleCache<base::Bytes> held_;
  mutable std::map<plan::ReplicaKey, base::Bytes> any_version_;  ///< for the mistake of that name
};

}  // namespace sleight::cluster
