// A run's results, as the archive's writer reads them: in logical order, and complete up to a scan
// that is the same for all chains. The run store provides a RunView; tests provide their own.
#pragma once

#include <cstdint>
#include <functional>

#include "common/plan/failure.h"
#include "common/plan/report.h"
#include "common/plan/unit.h"

namespace sleight::archive {

class RunView {
 public:
  virtual ~RunView() = default;
  virtual std::uint32_t chains() const = 0;
  /// Returns the cut: every chain has the draws 0 .. draws()-1. A draw is a scan's state at inverse
  /// temperature 1. In plain chains and tempered ladders, draws and scans coincide.
  virtual std::uint64_t draws() const = 0;
  /// Calls `visit` with the number and the record of each draw 0 .. draws()-1 of one chain.
  virtual void for_each_draw(
      base::ChainId chain,
      const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const = 0;

  /// Returns whether a satisfying draw may become a kept animation. A draw may not be kept if its
  /// lineage has not yet reached an independent solution.
  virtual bool may_be_kept(base::ChainId /*chain*/, base::ScanIndex /*draw*/) const { return true; }

  /// Maximum replicas of a chain. A plain chain has one replica, always at inverse temperature 1.
  virtual std::uint32_t replicas() const { return 1; }
  /// Calls `visit` for the chain's replicas, in order. Passes the replica's newest state whose scan
  /// is a multiple of `thin`. Skips replicas without such a state. Called only if replicas() > 1.
  virtual void for_each_replica(
      base::ChainId /*chain*/, std::uint64_t /*thin*/,
      const std::function<void(base::ReplicaId, base::ScanIndex,
                               const plan::ScanRecord&)>& /*visit*/) const {}
  /// Number of draws from the prior. Prior draws are visited in order from 0; records have no
  /// state.
  virtual std::uint64_t prior_draws() const { return 0; }
  virtual void for_each_prior_draw(
      const std::function<void(std::uint64_t nth, const plan::ScanRecord&)>& /*visit*/) const {}
  /// Number of scans of each find's relaxation. 0: the finds were not relaxed.
  virtual std::uint64_t relax_scans() const { return 0; }
  /// Number of finds of a search. Finds are visited in order, with the number of their start.
  virtual std::uint64_t finds() const { return 0; }
  virtual void for_each_find(
      const std::function<void(std::uint64_t start, const plan::ScanRecord&)>& /*visit*/) const {}
  /// Returns what the method learnt from these scans.
  virtual plan::Report report() const { return {}; }
  /// Counts the simulations that failed in these scans. Failures in any replica and failures before
  /// the first draw are included.
  virtual plan::FailureCounts failures() const { return {}; }
};

}  // namespace sleight::archive
