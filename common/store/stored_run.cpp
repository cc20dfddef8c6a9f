#include "common/store/stored_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "common/store/checksum.h"
#include "common/store/run_store.h"
#include "common/store/scan_rows.h"

namespace sleight::store {
namespace {

/// Draws are read for so many scans of a chain at once.
constexpr std::uint64_t k_scans_at_a_time = 256;

}  // namespace

StoredRun::StoredRun(const std::string& folder, std::uint32_t chains, std::uint64_t scans,
                     std::uint64_t finds)
    : database_(RunStore::database_path(folder), Access::read_only),
      chains_(chains),
      scans_(scans),
      finds_(finds) {
  salt_ = salt_of(run_value(database_, "identity"));
  replicas_ = count_replicas();
  draws_ = {.first_scan = 0, .count = scans};
}

RowKey StoredRun::key_of(base::ChainId chain, std::int64_t replica, std::int64_t scan) const {
  return {.salt = salt_,
          .replica = {chain, base::ReplicaId{static_cast<std::uint32_t>(replica)}},
          .scan = static_cast<std::uint64_t>(scan)};
}

std::uint32_t StoredRun::count_replicas() const {
  // Of those that the cut has: a ladder may have got more levels since.
  Statement most = database_.prepare(
      "SELECT MAX(replica) FROM replica AS known WHERE chain<?1 AND EXISTS(SELECT 1 FROM scan "
      "WHERE chain=known.chain AND replica=known.replica AND scan<?2)");
  most.bind(1, std::int64_t{chains_}).bind(2, static_cast<std::int64_t>(scans_));
  if (!most.step()) return 1;
  return static_cast<std::uint32_t>(most.integer(0)) + 1;
}

void StoredRun::for_each_draw(
    base::ChainId chain,
    const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const {
  Statement select = database_.prepare(fmt::format(
      "SELECT {}, scan FROM scan WHERE chain=?1 AND replica=?2 AND scan>=?3 AND scan<?4 "
      "AND inverse_temperature=1 ORDER BY scan",
      k_record_columns));
  select.bind(1, std::int64_t{chain.value});
  struct Draw {
    std::int64_t scan = 0;
    std::int64_t replica = 0;
    plan::ScanRecord record{};
  };
  std::vector<Draw> some;
  std::uint64_t draw = 0;
  for (const auto& [first, end] : draw_ranges()) {
    // Some scans at a time, of all replicas, in order. Nothing is being read while they are
    // visited, which may take long: a writer's log can be cut short meanwhile.
    for (std::uint64_t scan = first; scan < end; scan += k_scans_at_a_time) {
      some.clear();
      select.bind(3, static_cast<std::int64_t>(scan));
      select.bind(4, static_cast<std::int64_t>(std::min(end, scan + k_scans_at_a_time)));
      for (std::int64_t replica = 0; replica < std::int64_t{replicas_}; ++replica) {
        select.bind(2, replica);
        while (select.step()) {
          Draw& found = some.emplace_back();
          found = {.scan = select.integer(k_record_column_count), .replica = replica};
          read_record(database_, key_of(chain, replica, found.scan), select, 0, found.record);
        }
        select.reset();
      }
      std::ranges::sort(some, {}, [](const Draw& one) { return std::pair(one.scan, one.replica); });
      for (const Draw& one : some) {
        if (draw == draws_.count) break;
        visit(base::ScanIndex{draw++}, one.record);
      }
    }
  }
  if (draw != draws_.count) {
    refuse_damaged(database_.path(),
                   fmt::format("draw {} of chain {} is missing", draw, chain.value));
  }
}

std::vector<std::pair<std::uint64_t, std::uint64_t>> StoredRun::draw_ranges() const {
  if (draws_.parts.empty()) return {{draws_.first_scan, scans_}};
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
  for (const plan::DrawPart& part : draws_.parts)
    ranges.emplace_back(part.first_scan, part.first_scan + part.count);
  return ranges;
}

void StoredRun::set_draws(plan::Draws draws) {
  draws_ = std::move(draws);
  part_ends_.clear();
  for (const plan::DrawPart& part : draws_.parts)
    part_ends_.push_back((part_ends_.empty() ? 0 : part_ends_.back()) + part.count);
}

bool StoredRun::may_be_kept(base::ChainId chain, base::ScanIndex draw) const {
  const auto end = std::ranges::upper_bound(part_ends_, draw.value);
  if (end == part_ends_.end()) return true;
  const plan::DrawPart& part = draws_.parts[static_cast<std::size_t>(end - part_ends_.begin())];
  const auto& counted = part.counted.at(chain.value);
  // The part's last draw is the scan before its end.
  return counted && part.first_scan + part.count - (*end - draw.value) >= *counted;
}

void StoredRun::for_each_replica(base::ChainId chain, std::uint64_t thin,
                                 const std::function<void(base::ReplicaId, base::ScanIndex,
                                                          const plan::ScanRecord&)>& visit) const {
  Statement select = database_.prepare(
      fmt::format("SELECT scan, {} FROM scan WHERE chain=?1 AND replica=?2 AND scan<?3 AND "
                  "scan % ?4 = 0 AND state IS NOT NULL ORDER BY scan DESC LIMIT 1",
                  k_record_columns));
  for (std::uint32_t replica = 0; replica < replicas_; ++replica) {
    select.bind(1, std::int64_t{chain.value}).bind(2, std::int64_t{replica});
    select.bind(3, static_cast<std::int64_t>(scans_)).bind(4, static_cast<std::int64_t>(thin));
    if (select.step()) {
      plan::ScanRecord record;
      const std::int64_t scan = select.integer(0);
      read_record(database_, key_of(chain, replica, scan), select, 1, record);
      visit(base::ReplicaId{replica}, base::ScanIndex{static_cast<std::uint64_t>(scan)}, record);
    }
    select.reset();
  }
}

void StoredRun::for_each_find(
    const std::function<void(std::uint64_t, const plan::ScanRecord&)>& visit) const {
  // Starts are numbered by (scan, lane). Which ones found something is read first, then each by
  // itself, so that nothing is being read while it is visited.
  Statement select = database_.prepare(
      "SELECT chain, scan FROM scan WHERE chain>=?1 AND satisfied ORDER BY scan, chain LIMIT ?2");
  select.bind(1, std::int64_t{plan::k_first_lane}).bind(2, static_cast<std::int64_t>(finds_));
  std::vector<std::pair<std::int64_t, std::int64_t>> places;
  while (select.step())
    places.emplace_back(select.integer(0), select.integer(1));
  select.reset();
  Statement row = database_.prepare(fmt::format(
      "SELECT {} FROM scan WHERE chain=?1 AND replica=0 AND scan=?2", k_record_columns));
  plan::ScanRecord record;
  std::uint64_t found = 0;
  for (const auto& [lane, scan] : places) {
    const base::ChainId chain{static_cast<std::uint32_t>(lane)};
    row.bind(1, lane).bind(2, scan);
    if (!row.step()) break;
    read_record(database_, key_of(chain, 0, scan), row, 0, record);
    row.reset();
    visit(plan::start_number(chain, static_cast<std::uint64_t>(scan)), record);
    ++found;
  }
  if (found != finds_)
    refuse_damaged(database_.path(), fmt::format("find {} of its search is missing", found));
}

plan::FailureCounts StoredRun::failures() const {
  // Of a search those of the starts up to its last find.
  std::uint64_t last_start = 0;
  if (finds_ > 0)
    for_each_find([&](std::uint64_t start, const plan::ScanRecord&) { last_start = start; });
  Statement select = database_.prepare(
      fmt::format("SELECT chain, replica, scan, {} FROM scan INDEXED BY scan_failures "
                  "WHERE failures IS NOT NULL AND (chain>=?2 OR scan<?1)",
                  k_record_columns));
  select.bind(1, static_cast<std::int64_t>(scans_)).bind(2, std::int64_t{plan::k_first_lane});
  plan::FailureCounts counts;
  plan::ScanRecord record;
  while (select.step()) {
    const base::ChainId of{static_cast<std::uint32_t>(select.integer(0))};
    const auto scan = static_cast<std::uint64_t>(select.integer(2));
    const bool is_start = of.value >= plan::k_first_lane;
    if (is_start && (finds_ == 0 || plan::start_number(of, scan) > last_start)) continue;
    const base::ChainId chain{static_cast<std::uint32_t>(select.integer(0))};
    read_record(database_, key_of(chain, select.integer(1), select.integer(2)), select, 3, record);
    counts.add(record.failures);
  }
  return counts;
}

void StoredRun::replay(const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                                std::span<const plan::ScanRecord>)>& visit) const {
  for (std::uint32_t chain = 0; chain < chains_; ++chain) {
    for (std::uint32_t replica = 0; replica < replicas_; ++replica) {
      const plan::ReplicaKey key{base::ChainId{chain}, base::ReplicaId{replica}};
      replay_rows(database_, salt_, key, scans_,
                  [&](base::ScanIndex first, std::span<const plan::ScanRecord> records) {
                    visit(key, first, records);
                  });
    }
  }
}

void for_each_stored(const std::string& folder,
                     const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                              std::span<const plan::ScanRecord>)>& visit) {
  Database database(RunStore::database_path(folder), Access::read_only);
  const std::uint64_t salt = salt_of(run_value(database, "identity"));
  // How far each replica is at one moment; rows up to there never change.
  Statement select =
      database.prepare("SELECT chain, replica, next_scan FROM replica ORDER BY chain, replica");
  std::vector<std::pair<plan::ReplicaKey, std::uint64_t>> replicas;
  while (select.step()) {
    const plan::ReplicaKey key{base::ChainId{static_cast<std::uint32_t>(select.integer(0))},
                               base::ReplicaId{static_cast<std::uint32_t>(select.integer(1))}};
    replicas.emplace_back(key, static_cast<std::uint64_t>(select.integer(2)));
  }
  select.reset();
  for (const auto& [key, end] : replicas) {
    const std::uint64_t reached = replay_rows(
        database, salt, key, end,
        [&, replica = key](base::ScanIndex first, std::span<const plan::ScanRecord> records) {
          visit(replica, first, records);
        });
    if (reached != end) {
      refuse_damaged(database.path(),
                     fmt::format("scan {} of chain {} is missing", reached, key.chain.value));
    }
  }
}

}  // namespace sleight::store
