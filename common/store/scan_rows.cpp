#include "common/store/scan_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "common/store/checksum.h"

namespace sleight::store {
namespace {

constexpr std::size_t k_replay_batch = 4096;

/// The row's checksum detects a wrong length.
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
  if (!find.step()) refuse_damaged(database.path(), fmt::format("the {} is missing", key));
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

RowReplay::RowReplay(SharedDatabase& database, std::uint64_t salt, const plan::ReplicaKey& replica,
                     std::uint64_t end)
    : database_(&database), salt_(salt), replica_(replica), end_(end) {}

bool RowReplay::step(const ReplayVisit& visit) {
  if (is_over_) return false;
  static const std::string k_rows = fmt::format(
      "SELECT scan, {} FROM scan WHERE chain=?1 AND replica=?2 AND scan>=?3 AND scan<?4 "
      "ORDER BY scan LIMIT {}",
      k_record_columns, k_replay_batch);
  batch_.clear();
  {
    const SharedDatabase::Turn turn = database_->turn();
    Statement select = turn->prepare(k_rows);
    select.bind(1, std::int64_t{replica_.chain.value});
    select.bind(2, std::int64_t{replica_.replica.value});
    select.bind(3, static_cast<std::int64_t>(next_)).bind(4, static_cast<std::int64_t>(end_));
    while (select.step()) {
      const auto scan = static_cast<std::uint64_t>(select.integer(0));
      // A replica may have been added after its chain's first scan.
      if (!has_begun_) next_ = scan;
      has_begun_ = true;
      if (scan != next_) break;
      plan::ScanRecord& record = batch_.emplace_back();
      read_record(*turn, {.salt = salt_, .replica = replica_, .scan = scan}, select, 1, record);
      record.outcome = {};
      if (!plan::is_search_lane(replica_.chain)) record.state = {};
      ++next_;
    }
  }
  is_over_ = batch_.size() < k_replay_batch;
  // No statement is active between batches. So a writer can truncate its log. On a network disk,
  // the writer can take its turn.
  if (batch_.empty()) return false;
  visit(base::ScanIndex{next_ - batch_.size()}, batch_);
  return true;
}

void replay_together(std::span<RowReplay> replays,
                     const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                              std::span<const plan::ScanRecord>)>& visit) {
  while (true) {
    RowReplay* behind = nullptr;
    for (RowReplay& replay : replays) {
      if (!replay.is_over() && (behind == nullptr || replay.next() < behind->next()))
        behind = &replay;
    }
    if (behind == nullptr) return;
    behind->step([&](base::ScanIndex first, std::span<const plan::ScanRecord> records) {
      visit(behind->replica(), first, records);
    });
  }
}

std::uint64_t replay_rows(SharedDatabase& database, std::uint64_t salt,
                          const plan::ReplicaKey& replica, std::uint64_t end,
                          const ReplayVisit& visit) {
  RowReplay replay(database, salt, replica, end);
  while (replay.step(visit)) {
  }
  return replay.next();
}

}  // namespace sleight::store
