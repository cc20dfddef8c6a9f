// Reads scans from the run store's table as records. The records determine what a resumed plan does
// or what an archive contains, so every row's checksum is verified.
//
// Thread safety: as SharedDatabase.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/plan/unit.h"
#include "common/store/shared_database.h"

namespace sleight::store {

/// Returns the value of a key in the store's table `run`. Throws base::Error if the key is missing.
std::string run_value(SharedDatabase& database, std::string_view key);

/// The columns of the table `scan` that read_record reads, in this order. For a SELECT.
inline constexpr const char* k_record_columns =
    "log_prior, log_constraint, inverse_temperature, satisfied, lineage, proposed, accepted, "
    "outcome, failures, overlapping_starts, method_values, state, checksum";
inline constexpr int k_record_column_count = 13;

/// The key of a row, and the salt of its store.
struct RowKey {
  std::uint64_t salt = 0;
  plan::ReplicaKey replica;
  std::uint64_t scan = 0;
};

/// Reads k_record_columns from column `first` of the current row. If the row was changed, throws
/// base::Error that names its chain and scan.
void read_record(const Database& database, const RowKey& key, Statement& select, int first,
                 plan::ScanRecord& record);

using ReplayVisit = std::function<void(base::ScanIndex, std::span<const plan::ScanRecord>)>;

/// Visits a replica's scans in order, in batches. Begins at the replica's first scan. Ends before
/// `end`, or at a gap. Records have no outcome. Only records of finds have a state, because chains
/// may start from finds. A batch is read in one turn, then visited.
class RowReplay {
 public:
  /// Borrows `database`.
  RowReplay(SharedDatabase& database, std::uint64_t salt, const plan::ReplicaKey& replica,
            std::uint64_t end);

  /// Visits the next batch. False: no more batches.
  bool step(const ReplayVisit& visit);
  const plan::ReplicaKey& replica() const { return replica_; }
  /// Returns 1 + the number of the last visited scan. Returns 0 if none was visited.
  std::uint64_t next() const { return next_; }
  bool is_over() const { return is_over_; }

 private:
  SharedDatabase* database_;
  std::uint64_t salt_;
  plan::ReplicaKey replica_;
  std::uint64_t end_;
  std::uint64_t next_ = 0;
  bool has_begun_ = false;
  bool is_over_ = false;
  std::vector<plan::ScanRecord> batch_{};
};

/// Replays all replicas to their ends. Always reads the next batch of the replica that is furthest
/// behind. So a plan has to store only some batches even if replicas depend on each other, as in a
/// ladder.
void replay_together(std::span<RowReplay> replays,
                     const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                              std::span<const plan::ScanRecord>)>& visit);

/// Visits the scans that a RowReplay would visit. Records lack state and outcome. Returns 1 + the
/// number of the last scan, or 0 if there is no scan.
std::uint64_t replay_rows(SharedDatabase& database, std::uint64_t salt,
                          const plan::ReplicaKey& replica, std::uint64_t end,
                          const ReplayVisit& visit);

}  // namespace sleight::store
