#include "common/store/stored_run.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "common/store/checksum.h"
#include "common/store/columns.h"
#include "common/store/run_store.h"

namespace sleight::store {
namespace {

constexpr const char* k_record =
    "log_prior, log_constraint, inverse_temperature, satisfied, lineage, proposed, accepted, "
    "outcome, state, checksum";

constexpr int k_record_columns = 10;

/// The columns of k_record from `first` on, and what the row's checksum must be.
std::int64_t read_record(Statement& select, int first, plan::ScanRecord& record) {
  record.log_prior = select.real(first);
  record.log_constraint = select.real(first + 1);
  record.inverse_temperature = select.real(first + 2);
  record.satisfied = select.integer(first + 3) != 0;
  record.lineage = static_cast<std::uint64_t>(select.integer(first + 4));
  assign_bytes(record.proposed, select.blob(first + 5));
  assign_bytes(record.accepted, select.blob(first + 6));
  assign_bytes(record.outcome, select.blob(first + 7));
  assign_bytes(record.state, select.blob(first + 8));
  return select.integer(first + 9);
}

constexpr std::size_t k_replay_batch = 4096;

}  // namespace

StoredRun::StoredRun(const std::string& folder, std::uint32_t chains, std::uint64_t scans)
    : database_(RunStore::database_path(folder), Access::read_only),
      chains_(chains),
      scans_(scans) {
  Statement identity = database_.prepare("SELECT value FROM run WHERE key='identity'");
  if (!identity.step()) refuse_damaged(database_.path(), "it has no identity");
  salt_ = salt_of(identity.text(0));
  replicas_ = count_replicas();
  draws_ = {.first_scan = 0, .count = scans};
}

void StoredRun::check(const plan::ReplicaKey& replica, std::uint64_t scan,
                      const plan::ScanRecord& record, std::int64_t checksum) const {
  if (checksum_of(salt_, replica, scan, record) == checksum) return;
  refuse_damaged(database_.path(), fmt::format("scan {} of chain {}", scan, replica.chain.value));
}

std::uint32_t StoredRun::count_replicas() const {
  Statement most = database_.prepare("SELECT MAX(replica) FROM replica");
  if (!most.step()) return 1;
  return static_cast<std::uint32_t>(most.integer(0)) + 1;
}

void StoredRun::for_each_scan(
    base::ChainId chain,
    const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const {
  // Who was at inverse temperature 1: keys alone, so that little is sorted; then the rows.
  Statement who = database_.prepare(
      "SELECT replica, scan FROM scan WHERE chain=?1 AND scan>=?2 AND scan<?3 AND "
      "inverse_temperature=1 ORDER BY scan, replica");
  Statement plain = database_.prepare(fmt::format(
      "SELECT {}, scan FROM scan WHERE chain=?1 AND replica=0 AND scan>=?2 AND scan<?3 AND "
      "inverse_temperature=1 ORDER BY scan",
      k_record));
  Statement row = database_.prepare(
      fmt::format("SELECT {} FROM scan WHERE chain=?1 AND replica=?2 AND scan=?3", k_record));
  plan::ScanRecord record;
  std::uint64_t draw = 0;
  const auto hand_on = [&](Statement& select, std::int64_t replica, std::int64_t scan) {
    const std::int64_t checksum = read_record(select, 0, record);
    check({chain, base::ReplicaId{static_cast<std::uint32_t>(replica)}},
          static_cast<std::uint64_t>(scan), record, checksum);
    visit(base::ScanIndex{draw++}, record);
  };
  Statement& select = replicas_ == 1 ? plain : who;
  select.bind(1, std::int64_t{chain.value});
  select.bind(2, static_cast<std::int64_t>(draws_.first_scan));
  select.bind(3, static_cast<std::int64_t>(scans_));
  while (draw < draws_.count && select.step()) {
    if (replicas_ == 1) {
      hand_on(select, 0, select.integer(k_record_columns));
      continue;
    }
    row.bind(1, std::int64_t{chain.value}).bind(2, who.integer(0)).bind(3, who.integer(1));
    if (!row.step()) break;
    hand_on(row, who.integer(0), who.integer(1));
    row.reset();
  }
  if (draw != draws_.count) {
    refuse_damaged(database_.path(),
                   fmt::format("draw {} of chain {} is missing", draw, chain.value));
  }
}

void StoredRun::for_each_replica(base::ChainId chain, std::uint64_t thin,
                                 const std::function<void(base::ReplicaId, base::ScanIndex,
                                                          const plan::ScanRecord&)>& visit) const {
  Statement select = database_.prepare(
      fmt::format("SELECT scan, {} FROM scan WHERE chain=?1 AND replica=?2 AND scan<?3 AND "
                  "scan % ?4 = 0 AND state IS NOT NULL ORDER BY scan DESC LIMIT 1",
                  k_record));
  for (std::uint32_t replica = 0; replica < replicas_; ++replica) {
    select.bind(1, std::int64_t{chain.value}).bind(2, std::int64_t{replica});
    select.bind(3, static_cast<std::int64_t>(scans_)).bind(4, static_cast<std::int64_t>(thin));
    if (select.step()) {
      plan::ScanRecord record;
      const auto scan = static_cast<std::uint64_t>(select.integer(0));
      const std::int64_t checksum = read_record(select, 1, record);
      check({chain, base::ReplicaId{replica}}, scan, record, checksum);
      visit(base::ReplicaId{replica}, base::ScanIndex{scan}, record);
    }
    select.reset();
  }
}

void StoredRun::replay(const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                                std::span<const plan::ScanRecord>)>& visit) const {
  Statement select = database_.prepare(
      "SELECT scan, log_constraint, inverse_temperature, satisfied, lineage, proposed, accepted "
      "FROM scan WHERE chain=?1 AND replica=?2 AND scan<?3 ORDER BY scan");
  for (std::uint32_t chain = 0; chain < chains_; ++chain) {
    for (std::uint32_t replica = 0; replica < replicas_; ++replica) {
      const plan::ReplicaKey key{base::ChainId{chain}, base::ReplicaId{replica}};
      select.bind(1, std::int64_t{chain}).bind(2, std::int64_t{replica});
      select.bind(3, static_cast<std::int64_t>(scans_));
      std::vector<plan::ScanRecord> batch;
      std::uint64_t first = 0;
      const auto hand_on = [&] {
        if (!batch.empty()) visit(key, base::ScanIndex{first}, batch);
        first += batch.size();
        batch.clear();
      };
      while (select.step()) {
        if (first == 0 && batch.empty()) first = static_cast<std::uint64_t>(select.integer(0));
        plan::ScanRecord& record = batch.emplace_back();
        record.log_constraint = select.real(1);
        record.inverse_temperature = select.real(2);
        record.satisfied = select.integer(3) != 0;
        record.lineage = static_cast<std::uint64_t>(select.integer(4));
        assign_bytes(record.proposed, select.blob(5));
        assign_bytes(record.accepted, select.blob(6));
        if (batch.size() == k_replay_batch) hand_on();
      }
      hand_on();
      select.reset();
    }
  }
}

}  // namespace sleight::store
