// Scans as the run store's table holds them, read back as records. Whatever is read here decides
// something, what a resumed plan does or what an archive says, so every row's checksum is verified.
//
// Thread safety: as SharedDatabase's.
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

/// What a store says of itself under a key of its table `run`. Throws base::Error where it has no
/// such key.
std::string run_value(SharedDatabase& database, std::string_view key);

/// The columns that read_record reads, in its order, for a SELECT on table scan.
inline constexpr const char* k_record_columns =
    "log_prior, log_constraint, inverse_temperature, satisfied, lineage, proposed, accepted, "
    "outcome, failures, overlapping_starts, method_values, state, checksum";
inline constexpr int k_record_column_count = 13;

/// A row's key, and the salt of its store.
struct RowKey {
  std::uint64_t salt = 0;
  plan::ReplicaKey replica;
  std::uint64_t scan = 0;
};

/// Reads k_record_columns from column `first` of the present row. Throws base::Error, naming chain
/// and scan, if the row is not as it was written.
void read_record(const Database& database, const RowKey& key, Statement& select, int first,
                 plan::ScanRecord& record);

using ReplayVisit = std::function<void(base::ScanIndex, std::span<const plan::ScanRecord>)>;

/// A replica's scans below `end` in order, batch by batch, from its first one to the first gap;
/// records come without outcome, and without state but of finds, from which chains may start. Each
/// batch is a turn, and is visited after it.
class RowReplay {
 public:
  /// Borrows the database.
  RowReplay(SharedDatabase& database, std::uint64_t salt, const plan::ReplicaKey& replica,
            std::uint64_t end);

  /// Visits the next batch; false where there is none.
  bool step(const ReplayVisit& visit);
  const plan::ReplicaKey& replica() const { return replica_; }
  /// The scan after the last that was visited; 0 before the first.
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

/// All of them to their ends, the one that is least far first: of replicas that hang together, as a
/// ladder's do, a plan never has to keep more than some batches until the others have come.
void replay_together(std::span<RowReplay> replays,
                     const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                              std::span<const plan::ScanRecord>)>& visit);

/// Visits a replica's scans below `end` in order, in batches, from its first one to the first gap;
/// records come without state and outcome. Each batch is a turn, and is visited after it. Returns
/// the scan after the last, 0 if there is none.
std::uint64_t replay_rows(SharedDatabase& database, std::uint64_t salt,
                          const plan::ReplicaKey& replica, std::uint64_t end,
                          const ReplayVisit& visit);

}  // namespace sleight::store
