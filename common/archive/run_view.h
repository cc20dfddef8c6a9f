// A run's results as an archive is derived from them: complete up to one common scan, in logical
// order. The run store gives one; tests give theirs.
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
  /// Draws 0 .. draws()-1 are present for every chain: the cut. A draw is a scan's state at inverse
  /// temperature 1; of plain chains, and of tempered ladders, scan and draw are one.
  virtual std::uint64_t draws() const = 0;
  /// Calls `visit` for draws 0 .. draws()-1 of one chain, with their numbers.
  virtual void for_each_draw(
      base::ChainId chain,
      const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const = 0;

  /// Whether a draw may become a kept animation, if it satisfies: where one of a lineage's draws is
  /// its independent solution, that one and later ones.
  virtual bool may_be_kept(base::ChainId /*chain*/, base::ScanIndex /*draw*/) const { return true; }

  /// Of a chain, at most. Plain chains have one, which is at inverse temperature 1 all the time.
  virtual std::uint32_t replicas() const { return 1; }
  /// Calls `visit` for each replica of a chain that has one with its newest state at a multiple of
  /// `thin`, in order. Called where there are more replicas than one.
  virtual void for_each_replica(
      base::ChainId /*chain*/, std::uint64_t /*thin*/,
      const std::function<void(base::ReplicaId, base::ScanIndex,
                               const plan::ScanRecord&)>& /*visit*/) const {}
  /// Draws from the prior, with their numbers, from 0 in order; the records have no state.
  virtual std::uint64_t prior_draws() const { return 0; }
  virtual void for_each_prior_draw(
      const std::function<void(std::uint64_t nth, const plan::ScanRecord&)>& /*visit*/) const {}
  /// Scans of the chains that relaxed the finds; 0: they are as they were found.
  virtual std::uint64_t relax_scans() const { return 0; }
  /// Finds of a search, and visits each with the number of its start, in order.
  virtual std::uint64_t finds() const { return 0; }
  virtual void for_each_find(
      const std::function<void(std::uint64_t start, const plan::ScanRecord&)>& /*visit*/) const {}
  /// What the method learnt from these scans.
  virtual plan::Report report() const { return {}; }
  /// Simulations that failed in these scans, those of all replicas and before the first draw too.
  virtual plan::FailureCounts failures() const { return {}; }
};

}  // namespace sleight::archive
