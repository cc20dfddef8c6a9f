#include "common/store/stored_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/store/checksum.h"
#include "common/store/run_store.h"

namespace sleight::store {
namespace {

/// Number of scans that are read at once, to find a chain's draws.
constexpr std::uint64_t k_scans_at_a_time = 256;
/// Number of rows per turn. The number is small, because the rows' states may be large.
constexpr std::uint64_t k_rows_at_a_time = 64;
constexpr std::uint64_t k_failures_at_a_time = 1024;
/// Starts per turn. Only their success is read.
constexpr std::uint64_t k_starts_at_a_time = 16384;
constexpr std::uint64_t k_lanes = plan::k_island_lanes;

}  // namespace

StoredRun::StoredRun(const std::string& folder, const StoredCut& cut)
    : StoredRun(open_to_read(folder), cut) {}

StoredRun::StoredRun(std::shared_ptr<SharedDatabase> database, const StoredCut& cut)
    : database_(std::move(database)), cut_(cut) {
  salt_ = salt_of(run_value(*database_, "identity"));
  replicas_ = count_replicas();
  draws_ = {.first_scan = 0, .count = cut.scans};
}

RowKey StoredRun::key_of(base::ChainId chain, std::int64_t replica, std::int64_t scan) const {
  return {.salt = salt_,
          .replica = {chain, base::ReplicaId{static_cast<std::uint32_t>(replica)}},
          .scan = static_cast<std::uint64_t>(scan)};
}

std::uint32_t StoredRun::count_replicas() const {
  // Count only replicas within the cut, because a ladder may have gained levels since.
  const SharedDatabase::Turn turn = database_->turn();
  Statement most = turn->prepare(
      "SELECT MAX(replica) FROM replica AS known WHERE chain<?1 AND EXISTS(SELECT 1 FROM scan "
      "WHERE chain=known.chain AND replica=known.replica AND scan<?2)");
  most.bind(1, std::int64_t{cut_.chains}).bind(2, static_cast<std::int64_t>(cut_.scans));
  if (!most.step()) return 1;
  return static_cast<std::uint32_t>(most.integer(0)) + 1;
}

void StoredRun::for_each_draw(
    base::ChainId chain,
    const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const {
  if (cut_.of_islands) return for_each_island(visit);
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
    // Read some scans of all replicas, then visit them in order. No statement may be active during
    // the visits. Otherwise a writer could not truncate its log for a long time.
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

void StoredRun::for_each_island(
    const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const {
  for_each_row(
      cut_.scans, "island", [](std::uint64_t n) { return plan::place_of_island(n); },
      [&](std::uint64_t n, const plan::ScanRecord& record) { visit(base::ScanIndex{n}, record); });
}

void StoredRun::for_each_row(
    std::uint64_t count, const char* what, const PlaceOfRow& place_of,
    const std::function<void(std::uint64_t nth, const plan::ScanRecord&)>& visit) const {
  const std::string row =
      fmt::format("SELECT {} FROM scan WHERE chain=?1 AND replica=0 AND scan=?2", k_record_columns);
  std::vector<plan::ScanRecord> some;
  for (std::uint64_t first = 0; first < count; first += some.size()) {
    some.assign(std::min(count - first, k_rows_at_a_time), {});
    {
      const SharedDatabase::Turn turn = database_->turn();
      Statement select = turn->prepare(row);
      for (std::size_t i = 0; i < some.size(); ++i) {
        const auto [chain, scan] = place_of(first + i);
        select.bind(1, std::int64_t{chain.value}).bind(2, static_cast<std::int64_t>(scan));
        if (!select.step())
          refuse_damaged(database_->path(), fmt::format("{} {} is missing", what, first + i));
        read_record(*turn, key_of(chain, 0, static_cast<std::int64_t>(scan)), select, 0, some[i]);
        select.reset();
      }
    }
    for (std::size_t i = 0; i < some.size(); ++i)
      visit(first + i, some[i]);
  }
}

std::vector<std::pair<std::uint64_t, std::uint64_t>> StoredRun::draw_ranges() const {
  if (draws_.parts.empty()) return {{draws_.first_scan, cut_.scans}};
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
      select.bind(3, static_cast<std::int64_t>(cut_.scans))
          .bind(4, static_cast<std::int64_t>(thin));
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
  Statement select =
      turn->prepare("SELECT chain FROM replica WHERE chain>=?1 AND chain<?2 ORDER BY chain");
  select.bind(1, std::int64_t{plan::k_first_lane}).bind(2, std::int64_t{plan::k_first_prior_lane});
  std::vector<std::int64_t> lanes;
  while (select.step())
    lanes.push_back(select.integer(0));
  return lanes;
}

std::vector<std::pair<std::int64_t, std::int64_t>> StoredRun::find_places(
    std::uint64_t finds) const {
  std::vector<std::pair<std::int64_t, std::int64_t>> places;
  for (const std::int64_t lane : lanes()) {
    // A lane's finds are in order. So only a lane's first `finds` finds can be among the first
    // `finds` of all lanes.
    std::int64_t next = 0;
    for (std::uint64_t found = 0; found < finds;) {
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
  if (places.size() > finds) places.resize(finds);
  return places;
}

std::vector<std::int64_t> StoredRun::chains_of_takes() const {
  const SharedDatabase::Turn turn = database_->turn();
  Statement select = turn->prepare(
      "SELECT chain FROM replica AS known WHERE chain<?1 AND EXISTS(SELECT 1 FROM scan WHERE "
      "chain=known.chain AND replica=0 AND scan=?2 AND satisfied=1) ORDER BY chain LIMIT ?3");
  select.bind(1, std::int64_t{plan::k_first_lane}).bind(2, std::int64_t{cut_.relax_scans});
  select.bind(3, static_cast<std::int64_t>(cut_.finds));
  std::vector<std::int64_t> chains;
  while (select.step())
    chains.push_back(select.integer(0));
  return chains;
}

std::vector<StoredRun::FindRow> StoredRun::find_rows() const {
  const auto start_of = [](const std::pair<std::int64_t, std::int64_t>& place) {
    return plan::start_number(base::ChainId{static_cast<std::uint32_t>(place.second)},
                              static_cast<std::uint64_t>(place.first));
  };
  std::vector<FindRow> rows;
  if (cut_.relax_scans == 0) {
    for (const auto& place : find_places(cut_.finds))
      rows.push_back({.start = start_of(place), .chain = place.second, .scan = place.first});
    return rows;
  }
  // Chain k relaxes find k.
  const std::vector<std::int64_t> chains = chains_of_takes();
  if (chains.empty()) return rows;
  const auto places = find_places(static_cast<std::uint64_t>(chains.back()) + 1);
  for (const std::int64_t chain : chains) {
    if (static_cast<std::size_t>(chain) >= places.size()) break;
    rows.push_back({.start = start_of(places[static_cast<std::size_t>(chain)]),
                    .chain = chain,
                    .scan = cut_.relax_scans});
  }
  return rows;
}

void StoredRun::for_each_find(
    const std::function<void(std::uint64_t, const plan::ScanRecord&)>& visit) const {
  // Starts are numbered by (scan, lane). Determine their rows first.
  const std::vector<FindRow> rows = find_rows();
  for_each_row(
      rows.size(), "find",
      [&](std::uint64_t n) {
        return std::pair(base::ChainId{static_cast<std::uint32_t>(rows[n].chain)},
                         static_cast<std::uint64_t>(rows[n].scan));
      },
      [&](std::uint64_t n, const plan::ScanRecord& record) { visit(rows[n].start, record); });
  if (rows.size() != cut_.finds) {
    refuse_damaged(database_->path(), fmt::format("find {} is missing", rows.size()));
  }
}

void StoredRun::for_each_prior_draw(
    const std::function<void(std::uint64_t, const plan::ScanRecord&)>& visit) const {
  std::vector<plan::ScanRecord> draws(cut_.prior_draws);
  std::uint64_t read = 0;
  {
    const SharedDatabase::Turn turn = database_->turn();
    Statement select = turn->prepare(fmt::format(
        "SELECT {}, chain, scan FROM scan WHERE chain>=?1 AND chain<?3 AND replica=0 AND "
        "scan<=?2",
        k_record_columns));
    select.bind(1, std::int64_t{plan::k_first_prior_lane});
    select.bind(3, std::int64_t{plan::k_first_island_lane});
    select.bind(2, static_cast<std::int64_t>(cut_.prior_draws / plan::k_prior_lanes));
    while (select.step()) {
      const base::ChainId lane{static_cast<std::uint32_t>(select.integer(k_record_column_count))};
      const std::int64_t scan = select.integer(k_record_column_count + 1);
      const std::uint64_t nth = plan::prior_draw_number(lane, static_cast<std::uint64_t>(scan));
      if (nth >= draws.size()) continue;
      read_record(*turn, key_of(lane, 0, scan), select, 0, draws[nth]);
      ++read;
    }
  }
  if (read != draws.size()) refuse_damaged(database_->path(), "a draw from the prior is missing");
  for (std::uint64_t nth = 0; nth < draws.size(); ++nth)
    visit(nth, draws[nth]);
}

plan::FailureCounts StoredRun::failures() const {
  // Count the failures of all starts up to the last find. Count also the failures of all chains up
  // to the last take's chain.
  std::uint64_t starts = 0;
  std::int64_t chains = cut_.chains;
  std::uint64_t scans = cut_.scans;
  if (const std::vector<FindRow> rows = find_rows(); !rows.empty()) {
    starts = rows.back().start + 1;
    if (cut_.relax_scans > 0) {
      chains = rows.back().chain + 1;
      scans = std::uint64_t{cut_.relax_scans} + 1;
    }
  }
  // The rows are in the index's order, (scan, chain, replica). Each batch continues after the
  // previous one.
  const std::string rows = fmt::format(
      "SELECT chain, replica, scan, {} FROM scan INDEXED BY scan_failures "
      "WHERE failures IS NOT NULL AND (chain>=?2 OR (scan<?1 AND chain<?7)) AND scan>=?3 "
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
    select.bind(7, chains);
    select.bind(1, static_cast<std::int64_t>(scans)).bind(2, std::int64_t{plan::k_first_lane});
    select.bind(3, last.scan).bind(4, last.chain).bind(5, last.replica);
    select.bind(6, static_cast<std::int64_t>(k_failures_at_a_time));
    for (read = 0; select.step(); ++read) {
      last = {.scan = select.integer(2), .chain = select.integer(0), .replica = select.integer(1)};
      const base::ChainId chain{static_cast<std::uint32_t>(last.chain)};
      const auto scan = static_cast<std::uint64_t>(last.scan);
      if (plan::is_island_lane(chain)) {
        if (!cut_.of_islands || plan::island_number(chain, scan) >= cut_.scans) continue;
      } else if (chain.value >= plan::k_first_lane && plan::start_number(chain, scan) >= starts) {
        continue;
      }
      read_record(*turn, key_of(chain, last.replica, last.scan), select, 3, record);
      counts.add(record.failures);
    }
  } while (read == k_failures_at_a_time);
  return counts;
}

void StoredRun::replay(const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                                std::span<const plan::ScanRecord>)>& visit) const {
  std::vector<RowReplay> replays;
  for (std::uint64_t n = 0; cut_.of_islands && n < std::min(cut_.scans, k_lanes); ++n) {
    const base::ChainId lane = plan::place_of_island(n).first;
    const std::uint64_t scans = (cut_.scans + k_lanes - 1 - n) / k_lanes;
    replays.emplace_back(*database_, salt_, plan::ReplicaKey{lane, base::ReplicaId{0}}, scans);
  }
  for (std::uint32_t chain = 0; !cut_.of_islands && chain < cut_.chains; ++chain) {
    for (std::uint32_t replica = 0; replica < replicas_; ++replica) {
      const plan::ReplicaKey key{base::ChainId{chain}, base::ReplicaId{replica}};
      replays.emplace_back(*database_, salt_, key, cut_.scans);
    }
  }
  replay_together(replays, visit);
}

void for_each_stored(SharedDatabase& database,
                     const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                              std::span<const plan::ScanRecord>)>& visit) {
  const std::uint64_t salt = salt_of(run_value(database, "identity"));
  // Read the progress of all replicas at one moment. Rows up to this progress never change.
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
