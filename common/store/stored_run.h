// A run as it stands in its store, cut at a common scan: what archives are derived from.
//
// Reads beside a writer, in turns that are short; nothing is being read while rows are visited.
// Thread safety: one thread at a time.
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

/// How far a run is read.
struct StoredCut {
  std::uint32_t chains = 0;
  std::uint64_t scans = 0;  ///< the first so many of every chain
  std::uint64_t finds = 0;  ///< the first so many of its search; or takes, where finds are relaxed:
  std::uint32_t relax_scans = 0;  ///< then the scan of their chains that may be a take
  std::uint64_t prior_draws = 0;  ///< the first so many
  bool of_islands = false;  ///< its one chain's scans are free islands, by number (plan/unit.h)
};

class StoredRun final : public archive::RunView {
 public:
  /// REQUIRES: what the cut has is committed.
  StoredRun(std::shared_ptr<SharedDatabase> database, const StoredCut& cut);
  /// Through a connection of its own (open_to_read).
  StoredRun(const std::string& folder, const StoredCut& cut);
  /// Which of these are draws, where not all are. REQUIRES: so many are there.
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

  /// Visits the scans of every replica up to the cut, in batches, as RunStore::replay does: for a
  /// plan to learn from them what it learns.
  void replay(const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                       std::span<const plan::ScanRecord>)>& visit) const;
  void set_report(plan::Report report) { report_ = std::move(report); }

 private:
  std::uint32_t count_replicas() const;
  void for_each_island(
      const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const;
  /// Rows by their places, some at a time. `what` is said of one that is not there.
  using PlaceOfRow = std::function<std::pair<base::ChainId, std::uint64_t>(std::uint64_t nth)>;
  void for_each_row(
      std::uint64_t count, const char* what, const PlaceOfRow& place_of,
      const std::function<void(std::uint64_t nth, const plan::ScanRecord&)>& visit) const;
  /// Scans [first, end) that are draws, and all of them together.
  std::vector<std::pair<std::uint64_t, std::uint64_t>> draw_ranges() const;
  RowKey key_of(base::ChainId chain, std::int64_t replica, std::int64_t scan) const;

  /// The lanes of its search.
  std::vector<std::int64_t> lanes() const;
  /// The first so many starts of its search that found something, as (scan, lane), in order.
  std::vector<std::pair<std::int64_t, std::int64_t>> find_places(std::uint64_t finds) const;
  /// By take its chain: the first so many whose relaxed finds satisfy.
  std::vector<std::int64_t> chains_of_takes() const;
  /// Where each of finds() begins and is: the place of its start, and its row.
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
  std::vector<std::uint64_t> part_ends_{};  ///< of draws_.parts: draws up to and with each
  plan::Report report_;
};

/// Visits all scans that are committed, replica by replica in order, in batches, as one moment left
/// them; records come without state and outcome. Beside a writer: what it commits meanwhile is not
/// seen. Throws base::Error where the store can't be read, or has been changed.
void for_each_stored(SharedDatabase& database,
                     const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                              std::span<const plan::ScanRecord>)>& visit);

}  // namespace sleight::store
