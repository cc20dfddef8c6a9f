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

/// The columns that read_record reads, in order, for a SELECT on the table `scan`.
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

/// Reads k_record_columns from column `first` of the current row. Throws base::Error with chain and
/// scan if the row was changed.
void read_record(const Database& database, const RowKey& key, Statement& select, int first,
                 plan::ScanRecord& record);

using ReplayVisit = std::function<void(base::ScanIndex, std::span<const plan::ScanRecord>)>;

/// Visits a replica's scans below `end` in order, in batches, from its first scan to the first gap.
/// Records have no outcome. Only records of finds have a state, because chains may start from
/// finds. Each batch is read in one turn and visited afterwards.
class RowReplay {
 public:
  /// Borrows `database`.
  RowReplay(SharedDatabase& database, std::uint64_t salt, const plan::ReplicaKey& replica,
            std::uint64_t end);

  /// Visits the next batch. False: no more batches.
  bool step(const ReplayVisit& visit);
  const plan::ReplicaKey& replica() const { return replica_; }
  /// Returns the number of the scan after the last visited one; 0 before the first.
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

/// Replays all replicas to their ends. The next batch is always read for the replica that is
/// furthest behind. So if replicas depend on each other, as in a ladder, a plan never has to store
/// more than some batches.
void replay_together(std::span<RowReplay> replays,
                     const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                              std::span<const plan::ScanRecord>)>& visit);

/// Visits a replica's scans below `end` in order, in batches, from its first scan to the first gap.
/// Records lack state and outcome. Each batch is read in one turn and visited afterwards. Returns
/// the number of the scan after the last; 0 if there is no scan.
std::uint64_t replay_rows(SharedDatabase& database, std::uint64_t salt,
                          const plan::ReplicaKey& replica, std::uint64_t end,
                          const ReplayVisit& visit);

}  // namespace sleight::store
