#include "common/store/scan_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "common/store/checksum.h"

namespace sleight::store {
namespace {

constexpr std::size_t k_replay_batch = 4096;

/// A length that does not fit shows in the row's checksum.
template <class T>
void assign_bytes(std::vector<T>& values, base::BytesView bytes) {
  values.resize(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
}

plan::FailureCounts failures_in(base::BytesView bytes) {
  plan::FailureCounts counts;
  const std::size_t size = std::min(bytes.size(), sizeof(counts.by_kind));
  if (size > 0) std::memcpy(counts.by_kind.data(), bytes.data(), size);
  return counts;
}

}  // namespace

std::string run_value(SharedDatabase& database, std::string_view key) {
  const SharedDatabase::Turn turn = database.turn();
  Statement find = turn->prepare("SELECT value FROM run WHERE key=?1");
  find.bind(1, key);
  if (!find.step()) refuse_damaged(database.path(), fmt::format("it has no {}", key));
  return find.text(0);
}

void read_record(const Database& database, const RowKey& key, Statement& select, int first,
                 plan::ScanRecord& record) {
  record.log_prior = select.real(first);
  record.log_constraint = select.real(first + 1);
  record.inverse_temperature = select.real(first + 2);
  record.satisfied = select.integer(first + 3) != 0;
  record.lineage = static_cast<std::uint64_t>(select.integer(first + 4));
  assign_bytes(record.proposed, select.blob(first + 5));
  assign_bytes(record.accepted, select.blob(first + 6));
  assign_bytes(record.outcome, select.blob(first + 7));
  record.failures = failures_in(select.blob(first + 8));
  record.overlapping_starts = static_cast<std::uint64_t>(select.integer(first + 9));
  assign_bytes(record.method_values, select.blob(first + 10));
  assign_bytes(record.state, select.blob(first + 11));
  if (checksum_of(key.salt, key.replica, key.scan, record) != select.integer(first + 12)) {
    refuse_damaged(database.path(),
                   fmt::format("scan {} of chain {}", key.scan, key.replica.chain.value));
  }
}

std::uint64_t replay_rows(SharedDatabase& database, std::uint64_t salt,
                          const plan::ReplicaKey& replica, std::uint64_t end,
                          const ReplayVisit& visit) {
  const std::string rows = fmt::format(
      "SELECT scan, {} FROM scan WHERE chain=?1 AND replica=?2 AND scan>=?3 AND scan<?4 "
      "ORDER BY scan LIMIT {}",
      k_record_columns, k_replay_batch);
  std::vector<plan::ScanRecord> batch;
  std::uint64_t next = 0;
  bool has_begun = false;
  do {
    batch.clear();
    {
      const SharedDatabase::Turn turn = database.turn();
      Statement select = turn->prepare(rows);
      select.bind(1, std::int64_t{replica.chain.value});
      select.bind(2, std::int64_t{replica.replica.value});
      select.bind(3, static_cast<std::int64_t>(next)).bind(4, static_cast<std::int64_t>(end));
      while (select.step()) {
        const auto scan = static_cast<std::uint64_t>(select.integer(0));
        // A replica may have come into being later than its chain.
        if (!has_begun) next = scan;
        has_begun = true;
        if (scan != next) break;
        plan::ScanRecord& record = batch.emplace_back();
        read_record(*turn, {.salt = salt, .replica = replica, .scan = scan}, select, 1, record);
        record.outcome = {};
        record.state = {};
        ++next;
      }
    }
    // Between batches nothing is being read: a writer's log can be cut short meanwhile, and on a
    // network disk it has its turn.
    if (!batch.empty()) visit(base::ScanIndex{next - batch.size()}, batch);
  } while (batch.size() == k_replay_batch);
  return next;
}

}  // namespace sleight::store
