// A run's results, read from its store, up to a scan that all chains have. Archives are derived
// from them.
//
// Can be used while a writer is active. Reading is done in short turns, and no statement is active
// while rows are visited. Thread safety: one thread at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/archive/run_view.h"
#include "common/plan/plan.h"
#include "common/store/scan_rows.h"
#include "common/store/shared_database.h"

namespace sleight::store {

/// The part of a run that is read.
struct StoredCut {
  std::uint32_t chains = 0;
  std::uint64_t scans = 0;        ///< the first `scans` of every chain
  std::uint64_t finds = 0;        ///< the first `finds` of the search, or takes if relaxed
  std::uint32_t relax_scans = 0;  ///< if finds are relaxed: the scan that may be a take
  std::uint64_t prior_draws = 0;  ///< the first `prior_draws`
  bool of_islands = false;        ///< the only chain's scans are free islands (plan/unit.h)
};

class StoredRun final : public archive::RunView {
 public:
  /// REQUIRES: everything in the cut is committed.
  StoredRun(std::shared_ptr<SharedDatabase> database, const StoredCut& cut);
  /// Opens a separate connection (open_to_read).
  StoredRun(const std::string& folder, const StoredCut& cut);
  /// Sets which scans are draws, if not all scans are. REQUIRES: these scans are in the cut.
  void set_draws(plan::Draws draws);

  std::uint32_t chains() const override { return cut_.chains; }
  std::uint64_t draws() const override { return draws_.count; }
  void for_each_draw(
      base::ChainId chain,
      const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const override;
  bool may_be_kept(base::ChainId chain, base::ScanIndex draw) const override;
  std::uint32_t replicas() const override { return replicas_; }
  void for_each_replica(base::ChainId chain, std::uint64_t thin,
                        const std::function<void(base::ReplicaId, base::ScanIndex,
                                                 const plan::ScanRecord&)>& visit) const override;
  std::uint64_t finds() const override { return cut_.finds; }
  std::uint64_t relax_scans() const override { return cut_.relax_scans; }
  void for_each_find(
      const std::function<void(std::uint64_t, const plan::ScanRecord&)>& visit) const override;
  std::uint64_t prior_draws() const override { return cut_.prior_draws; }
  void for_each_prior_draw(
      const std::function<void(std::uint64_t, const plan::ScanRecord&)>& visit) const override;
  plan::Report report() const override { return report_; }
  plan::FailureCounts failures() const override;

  /// Visits the scans of all replicas up to the cut, in batches. A plan can learn from these scans.
  /// Records are as in RunStore::replay.
  void replay(const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                       std::span<const plan::ScanRecord>)>& visit) const;
  void set_report(plan::Report report) { report_ = std::move(report); }

 private:
  std::uint32_t count_replicas() const;
  void for_each_island(
      const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const;
  /// Visits rows at the given places, in batches. `what`: what an error calls a missing row.
  using PlaceOfRow = std::function<std::pair<base::ChainId, std::uint64_t>(std::uint64_t nth)>;
  void for_each_row(
      std::uint64_t count, const char* what, const PlaceOfRow& place_of,
      const std::function<void(std::uint64_t nth, const plan::ScanRecord&)>& visit) const;
  /// Returns the ranges [first, end) of scans that are draws.
  std::vector<std::pair<std::uint64_t, std::uint64_t>> draw_ranges() const;
  RowKey key_of(base::ChainId chain, std::int64_t replica, std::int64_t scan) const;

  std::vector<std::int64_t> lanes() const;
  /// Returns the first `finds` successful starts of the search, as (scan, lane), in order.
  std::vector<std::pair<std::int64_t, std::int64_t>> find_places(std::uint64_t finds) const;
  /// Returns the chains that made the takes: the first chains whose last state satisfies the
  /// constraint.
  std::vector<std::int64_t> chains_of_takes() const;
  /// The number of a find's start, and the find's row.
  struct FindRow {
    std::uint64_t start = 0;
    std::int64_t chain = 0;
    std::int64_t scan = 0;
  };
  std::vector<FindRow> find_rows() const;

  std::shared_ptr<SharedDatabase> database_;
  StoredCut cut_;
  std::uint64_t salt_ = 0;
  std::uint32_t replicas_ = 1;
  plan::Draws draws_;
  std::vector<std::uint64_t> part_ends_{};  ///< draws up to the end of each of draws_.parts
  plan::Report report_;
};

/// Visits all committed scans, in batches. Visits one replica after the other, each replica's scans
/// in order. Does not see what a writer commits during the visit. Records lack state and outcome.
/// Throws base::Error if the store can't be read or was changed.
void for_each_stored(SharedDatabase& database,
                     const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                              std::span<const plan::ScanRecord>)>& visit);

}  // namespace sleight::store
