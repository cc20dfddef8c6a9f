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
/// In one turn: their states may be large.
constexpr std::size_t k_finds_at_a_time = 64;
constexpr std::uint64_t k_failures_at_a_time = 1024;
/// Of these, only whether they found something is read.
constexpr std::uint64_t k_starts_at_a_time = 16384;

}  // namespace

StoredRun::StoredRun(const std::string& folder, std::uint32_t chains, std::uint64_t scans,
                     std::uint64_t finds)
    : StoredRun(open_to_read(folder), chains, scans, finds) {}

StoredRun::StoredRun(std::shared_ptr<SharedDatabase> database, std::uint32_t chains,
                     std::uint64_t scans, std::uint64_t finds)
    : database_(std::move(database)), chains_(chains), scans_(scans), finds_(finds) {
  salt_ = salt_of(run_value(*database_, "identity"));
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
  const SharedDatabase::Turn turn = database_->turn();
  Statement most = turn->prepare(
      "SELECT MAX(replica) FROM replica AS known WHERE chain<?1 AND EXISTS(SELECT 1 FROM scan "
      "WHERE chain=known.chain AND replica=known.replica AND scan<?2)");
  most.bind(1, std::int64_t{chains_}).bind(2, static_cast<std::int64_t>(scans_));
  if (!most.step()) return 1;
  return static_cast<std::uint32_t>(most.integer(0)) + 1;
}

void StoredRun::for_each_draw(
    base::ChainId chain,
    const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const {
  const std::string rows = fmt::format(
      "SELECT {}, scan FROM scan WHERE chain=?1 AND replica=?2 AND scan>=?3 AND scan<?4 "
      "AND inverse_temperature=1 ORDER BY scan",
      k_record_columns);
  struct Draw {
    std::int64_t scan = 0;
    std::int64_t replica = 0;
    plan::ScanRecord record{};
  };
  std::vector<Draw> some;
  const auto read_some = [&](std::uint64_t scan, std::uint64_t end) {
    some.clear();
    const SharedDatabase::Turn turn = database_->turn();
    Statement select = turn->prepare(rows);
    select.bind(1, std::int64_t{chain.value});
    select.bind(3, static_cast<std::int64_t>(scan)).bind(4, static_cast<std::int64_t>(end));
    for (std::int64_t replica = 0; replica < std::int64_t{replicas_}; ++replica) {
      select.bind(2, replica);
      while (select.step()) {
        Draw& found = some.emplace_back();
        found = {.scan = select.integer(k_record_column_count), .replica = replica};
        read_record(*turn, key_of(chain, replica, found.scan), select, 0, found.record);
      }
      select.reset();
    }
  };
  std::uint64_t draw = 0;
  for (const auto& [first, end] : draw_ranges()) {
    // Some scans at a time, of all replicas, in order. Nothing is being read while they are
    // visited, which may take long: a writer's log can be cut short meanwhile.
    for (std::uint64_t scan = first; scan < end; scan += k_scans_at_a_time) {
      read_some(scan, std::min(end, scan + k_scans_at_a_time));
      std::ranges::sort(some, {}, [](const Draw& one) { return std::pair(one.scan, one.replica); });
      for (const Draw& one : some) {
        if (draw == draws_.count) break;
        visit(base::ScanIndex{draw++}, one.record);
      }
    }
  }
  if (draw != draws_.count) {
    refuse_damaged(database_->path(),
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
  const std::string row = fmt::format(
      "SELECT scan, {} FROM scan WHERE chain=?1 AND replica=?2 AND scan<?3 AND "
      "scan % ?4 = 0 AND state IS NOT NULL ORDER BY scan DESC LIMIT 1",
      k_record_columns);
  for (std::uint32_t replica = 0; replica < replicas_; ++replica) {
    plan::ScanRecord record;
    std::optional<std::int64_t> scan;
    {
      const SharedDatabase::Turn turn = database_->turn();
      Statement select = turn->prepare(row);
      select.bind(1, std::int64_t{chain.value}).bind(2, std::int64_t{replica});
      select.bind(3, static_cast<std::int64_t>(scans_)).bind(4, static_cast<std::int64_t>(thin));
      if (select.step()) {
        scan = select.integer(0);
        read_record(*turn, key_of(chain, replica, *scan), select, 1, record);
      }
    }
    if (scan)
      visit(base::ReplicaId{replica}, base::ScanIndex{static_cast<std::uint64_t>(*scan)}, record);
  }
}

std::vector<std::int64_t> StoredRun::lanes() const {
  const SharedDatabase::Turn turn = database_->turn();
  Statement select = turn->prepare("SELECT chain FROM replica WHERE chain>=?1 ORDER BY chain");
  select.bind(1, std::int64_t{plan::k_first_lane});
  std::vector<std::int64_t> lanes;
  while (select.step())
    lanes.push_back(select.integer(0));
  return lanes;
}

std::vector<std::pair<std::int64_t, std::int64_t>> StoredRun::find_places() const {
  std::vector<std::pair<std::int64_t, std::int64_t>> places;
  for (const std::int64_t lane : lanes()) {
    // A lane's finds are in order: none after its first finds_ is among the first of all.
    std::int64_t next = 0;
    for (std::uint64_t found = 0; found < finds_;) {
      const SharedDatabase::Turn turn = database_->turn();
      Statement select = turn->prepare(
          "SELECT scan, satisfied FROM scan WHERE chain=?1 AND replica=0 AND scan>=?2 "
          "ORDER BY scan LIMIT ?3");
      select.bind(1, lane).bind(2, next);
      select.bind(3, static_cast<std::int64_t>(k_starts_at_a_time));
      std::uint64_t rows = 0;
      for (; select.step(); ++rows) {
        next = select.integer(0) + 1;
        if (select.integer(1) == 0) continue;
        places.emplace_back(select.integer(0), lane);
        ++found;
      }
      if (rows < k_starts_at_a_time) break;
    }
  }
  std::ranges::sort(places);
  if (places.size() > finds_) places.resize(finds_);
  return places;
}

void StoredRun::for_each_find(
    const std::function<void(std::uint64_t, const plan::ScanRecord&)>& visit) const {
  // Starts are numbered by (scan, lane). Which ones found something is read first, then some of
  // them at a time, so that nothing is being read while they are visited.
  const std::string row =
      fmt::format("SELECT {} FROM scan WHERE chain=?1 AND replica=0 AND scan=?2", k_record_columns);
  const auto places = find_places();
  std::vector<plan::ScanRecord> some;
  std::uint64_t found = 0;
  while (found < places.size()) {
    const std::size_t count = std::min<std::size_t>(places.size() - found, k_finds_at_a_time);
    some.assign(count, {});
    {
      const SharedDatabase::Turn turn = database_->turn();
      Statement select = turn->prepare(row);
      for (std::size_t i = 0; i < count; ++i) {
        const auto& [scan, lane] = places[found + i];
        select.bind(1, lane).bind(2, scan);
        if (!select.step()) refuse_damaged(database_->path(), "a find of its search is missing");
        read_record(*turn, key_of(base::ChainId{static_cast<std::uint32_t>(lane)}, 0, scan), select,
                    0, some[i]);
        select.reset();
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [scan, lane] = places[found + i];
      visit(plan::start_number(base::ChainId{static_cast<std::uint32_t>(lane)},
                               static_cast<std::uint64_t>(scan)),
            some[i]);
    }
    found += count;
  }
  if (found != finds_)
    refuse_damaged(database_->path(), fmt::format("find {} of its search is missing", found));
}

plan::FailureCounts StoredRun::failures() const {
  // Of a search those of the starts up to its last find.
  std::uint64_t last_start = 0;
  if (finds_ > 0) {
    const auto places = find_places();
    if (!places.empty()) {
      last_start =
          plan::start_number(base::ChainId{static_cast<std::uint32_t>(places.back().second)},
                             static_cast<std::uint64_t>(places.back().first));
    }
  }
  // By (scan, chain, replica), as the index has them; each batch goes on after the last one's end.
  const std::string rows = fmt::format(
      "SELECT chain, replica, scan, {} FROM scan INDEXED BY scan_failures "
      "WHERE failures IS NOT NULL AND (chain>=?2 OR scan<?1) AND scan>=?3 "
      "AND (scan, chain, replica)>(?3, ?4, ?5) ORDER BY scan, chain, replica LIMIT ?6",
      k_record_columns);
  plan::FailureCounts counts;
  plan::ScanRecord record;
  struct {
    std::int64_t scan = -1;
    std::int64_t chain = -1;
    std::int64_t replica = -1;
  } last;
  std::uint64_t read = 0;
  do {
    const SharedDatabase::Turn turn = database_->turn();
    Statement select = turn->prepare(rows);
    select.bind(1, static_cast<std::int64_t>(scans_)).bind(2, std::int64_t{plan::k_first_lane});
    select.bind(3, last.scan).bind(4, last.chain).bind(5, last.replica);
    select.bind(6, static_cast<std::int64_t>(k_failures_at_a_time));
    for (read = 0; select.step(); ++read) {
      last = {.scan = select.integer(2), .chain = select.integer(0), .replica = select.integer(1)};
      const base::ChainId chain{static_cast<std::uint32_t>(last.chain)};
      const bool is_start = chain.value >= plan::k_first_lane;
      if (is_start && (finds_ == 0 || plan::start_number(chain, static_cast<std::uint64_t>(
                                                                    last.scan)) > last_start))
        continue;
      read_record(*turn, key_of(chain, last.replica, last.scan), select, 3, record);
      counts.add(record.failures);
    }
  } while (read == k_failures_at_a_time);
  return counts;
}

void StoredRun::replay(const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                                std::span<const plan::ScanRecord>)>& visit) const {
  std::vector<RowReplay> replays;
  for (std::uint32_t chain = 0; chain < chains_; ++chain) {
    for (std::uint32_t replica = 0; replica < replicas_; ++replica) {
      const plan::ReplicaKey key{base::ChainId{chain}, base::ReplicaId{replica}};
      replays.emplace_back(*database_, salt_, key, scans_);
    }
  }
  replay_together(replays, visit);
}

void for_each_stored(SharedDatabase& database,
                     const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                              std::span<const plan::ScanRecord>)>& visit) {
  const std::uint64_t salt = salt_of(run_value(database, "identity"));
  // How far each replica is at one moment; rows up to there never change.
  std::vector<std::pair<plan::ReplicaKey, std::uint64_t>> replicas;
  {
    const SharedDatabase::Turn turn = database.turn();
    Statement select =
        turn->prepare("SELECT chain, replica, next_scan FROM replica ORDER BY chain, replica");
    while (select.step()) {
      const plan::ReplicaKey key{base::ChainId{static_cast<std::uint32_t>(select.integer(0))},
                                 base::ReplicaId{static_cast<std::uint32_t>(select.integer(1))}};
      replicas.emplace_back(key, static_cast<std::uint64_t>(select.integer(2)));
    }
  }
  std::vector<RowReplay> replays;
  for (const auto& [key, end] : replicas)
    replays.emplace_back(database, salt, key, end);
  replay_together(replays, visit);
  for (std::size_t i = 0; i < replays.size(); ++i) {
    if (replays[i].next() != replicas[i].second) {
      refuse_damaged(database.path(),
                     fmt::format("scan {} of chain {} is missing", replays[i].next(),
                                 replicas[i].first.chain.value));
    }
  }
}

}  // namespace sleight::store
