#include "common/store/run_store.h"

#include <fmt/format.h>

#include <charconv>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/store/checksum.h"
#include "common/store/stored_run.h"
#include "common/store/take_over.h"

namespace sleight::store {
namespace {

// A density's column has no type, because a REAL column would return a stored -0 as 0. If a scan
// has no failures, `failures` is NULL. So the index of `failures` is empty in most runs.
constexpr const char* k_schema = R"(
  CREATE TABLE IF NOT EXISTS run(key TEXT PRIMARY KEY, value) WITHOUT ROWID;
  CREATE TABLE IF NOT EXISTS scan(
    chain INTEGER, replica INTEGER, scan INTEGER,
    log_prior NOT NULL, log_constraint NOT NULL, inverse_temperature NOT NULL,
    satisfied INTEGER NOT NULL, lineage INTEGER NOT NULL,
    proposed BLOB NOT NULL, accepted BLOB NOT NULL, outcome BLOB NOT NULL,
    failures BLOB, overlapping_starts INTEGER NOT NULL,
    method_values BLOB, state BLOB, checksum INTEGER NOT NULL,
    PRIMARY KEY(chain, replica, scan)) WITHOUT ROWID;
  CREATE INDEX IF NOT EXISTS scan_failures ON scan(scan) WHERE failures IS NOT NULL;
  CREATE TABLE IF NOT EXISTS replica(
    chain INTEGER, replica INTEGER, next_scan INTEGER NOT NULL, state BLOB NOT NULL,
    checksum INTEGER NOT NULL,
    PRIMARY KEY(chain, replica)) WITHOUT ROWID;
  CREATE TABLE IF NOT EXISTS session(
    epoch INTEGER PRIMARY KEY, program_version TEXT NOT NULL, scans_before INTEGER NOT NULL,
    ended TEXT NOT NULL, checksum INTEGER NOT NULL);
  CREATE TABLE IF NOT EXISTS event(
    number INTEGER PRIMARY KEY, line TEXT NOT NULL, checksum INTEGER NOT NULL);
  CREATE TABLE IF NOT EXISTS told(
    id INTEGER PRIMARY KEY CHECK(id=0), scans INTEGER NOT NULL, starts INTEGER NOT NULL,
    solutions INTEGER NOT NULL, finds INTEGER NOT NULL, failures INTEGER NOT NULL,
    checksum INTEGER NOT NULL);
)";

constexpr const char* k_insert_event = "INSERT INTO event VALUES(?1,?2,?3)";

/// Ignores errors, because SQLite may already have rolled back.
void roll_back(Database& database) {
  try {
    database.execute("ROLLBACK");
  } catch (const base::Error&) {
  }
}

}  // namespace

namespace {

std::shared_ptr<SharedDatabase> open_to_write(const std::string& folder, RunLock* lock) {
  if (lock != nullptr && lock->owes_copies()) replace_files_of_run(folder, *lock);
  return std::make_shared<SharedDatabase>(RunStore::database_path(folder), Access::read_write);
}

}  // namespace

struct RunStore::Writer {
  Writer(Database& database, GroupCommit::Commit commit)
      : insert_scan(
            database.prepare("INSERT OR IGNORE INTO scan "
                             "VALUES(?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12,?13,?14,?15,?16)")),
        advance_replica(database.prepare(
            "INSERT INTO replica VALUES(?1,?2,?3,?4,?5) ON CONFLICT DO UPDATE "
            "SET next_scan=excluded.next_scan, state=excluded.state, checksum=excluded.checksum "
            "WHERE excluded.next_scan > next_scan")),
        next_scan(database.prepare("SELECT next_scan FROM replica WHERE chain=?1 AND replica=?2")),
        current_epoch(database.prepare("SELECT value FROM run WHERE key='epoch'")),
        insert_event(database.prepare(k_insert_event)),
        set_told(database.prepare("INSERT OR REPLACE INTO told VALUES(0,?1,?2,?3,?4,?5,?6)")),
        group_commit(std::move(commit)) {}

  Statement insert_scan;
  Statement advance_replica;
  Statement next_scan;
  Statement current_epoch;
  Statement insert_event;
  Statement set_told;
  GroupCommit group_commit;  // last member: its thread uses the statements
};

RunStore::RunStore(const std::string& folder, const RunIdentity& identity, RunLock* lock)
    : lock_(lock),
      connection_(open_to_write(folder, lock)),
      database_(connection_->only_database()) {
  create_or_check(identity);
  // Sync the folder, because a new file's name is durable only after that.
  base::PosixFileSystem file_system;
  file_system.sync_directory_of(database_path(folder));
  file_system.sync_directory_of(folder);
  writer_ =
      std::make_unique<Writer>(database_, [this](GroupCommit::Group& group) { commit(group); });
}

RunStore::~RunStore() = default;

void RunStore::create_or_check(const RunIdentity& identity) {
  database_.execute("BEGIN IMMEDIATE");
  database_.execute(k_schema);
  Statement find = database_.prepare("SELECT value FROM run WHERE key=?1");
  const auto stored_text = [&](std::string_view key) -> std::optional<std::string> {
    find.bind(1, key);
    std::optional<std::string> value;
    if (find.step()) value = find.text(0);
    find.reset();
    return value;
  };

  // Refuse a store that belongs to another run.
  const std::string& path = database_.path();
  if (const auto format = stored_text("format_version");
      format && *format != std::to_string(k_store_format)) {
    throw base::Error(base::ExitCode::conflict,
                      fmt::format("{}: the run store has format {}, but this program writes format "
                                  "{}; use --fresh to start over, or another output",
                                  path, *format, k_store_format));
  }
  if (const auto text = stored_text("identity"); text && *text != identity.identity_text) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: contains the run of another request ([world], [constraint], [sampler] or "
                    "thin differ); choose another output, or use --fresh to discard that run",
                    path));
  }
  if (const auto version = stored_text("results_version");
      version && *version != identity.results_version) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: the stored results have version {} (sleight {}), but this program "
                    "computes version {} (sleight {}); a run can't mix versions; resume with the "
                    "sleight version that stored the results, or use --fresh to start over",
                    path, *version, stored_text("program_version").value_or("?"),
                    identity.results_version, identity.program_version));
  }

  // Refuse a store that has results but no keys to identify their run.
  const bool is_new = !stored_text("epoch");
  Statement any =
      database_.prepare("SELECT EXISTS(SELECT 1 FROM scan), EXISTS(SELECT 1 FROM replica)");
  const bool has_rows = any.step() && (any.integer(0) != 0 || any.integer(1) != 0);
  any.reset();
  for (const char* key : {"format_version", "identity", "results_version", "epoch"}) {
    if (!stored_text(key) && (has_rows || !is_new)) {
      refuse_damaged(path, fmt::format("the {} is missing", key));
    }
  }
  salt_ = salt_of(identity.identity_text);
  take_epoch(stored_text("epoch"), identity);
  read_told();
  refuse_if_lock_is_lost();
  database_.execute("COMMIT");
  refuse_if_lock_is_lost();
}

void RunStore::take_epoch(const std::optional<std::string>& last, const RunIdentity& identity) {
  epoch_ = 1;
  if (last) {
    const char* end = last->data() + last->size();
    const auto [rest, failure] = std::from_chars(last->data(), end, epoch_);
    if (failure != std::errc() || rest != end)
      refuse_damaged(database_.path(), "the epoch is invalid");
    ++epoch_;
  }
  Statement set = database_.prepare("INSERT OR REPLACE INTO run VALUES(?1,?2)");
  set.bind(1, "format_version").bind(2, k_store_format).run();
  set.bind(1, "identity").bind(2, identity.identity_text).run();
  set.bind(1, "request").bind(2, identity.request_text).run();
  set.bind(1, "results_version").bind(2, identity.results_version).run();
  set.bind(1, "program_version").bind(2, identity.program_version).run();
  set.bind(1, "chains").bind(2, std::int64_t{identity.chains}).run();
  set.bind(1, "epoch").bind(2, static_cast<std::int64_t>(epoch_)).run();

  // Record the session before it does anything else. So even a session that dies leaves this row.
  program_version_ = identity.program_version;
  Statement sum = database_.prepare("SELECT COALESCE(SUM(next_scan), 0) FROM replica");
  if (sum.step()) scans_before_ = static_cast<std::uint64_t>(sum.integer(0));
  sum.reset();
  set_session("");
  if (lock_ != nullptr) lock_->set_epoch(epoch_);
}

void RunStore::set_session(const std::string& end) {
  const std::int64_t sum =
      checksum_of(SessionKey{.salt = salt_, .epoch = epoch_}, program_version_, scans_before_, end);
  database_.prepare("INSERT OR REPLACE INTO session VALUES(?1,?2,?3,?4,?5)")
      .bind(1, static_cast<std::int64_t>(epoch_))
      .bind(2, program_version_)
      .bind(3, static_cast<std::int64_t>(scans_before_))
      .bind(4, end)
      .bind(5, sum)
      .run();
}

void RunStore::read_told() {
  Statement select =
      database_.prepare("SELECT scans, starts, solutions, finds, failures, checksum FROM told");
  if (select.step()) {
    const auto count = [&](int column) {
      return static_cast<std::uint64_t>(select.integer(column));
    };
    told_ = {.scans = count(0),
             .starts = count(1),
             .solutions = count(2),
             .finds = count(3),
             .failures = count(4)};
    if (checksum_of(salt_, told_) != select.integer(5))
      refuse_damaged(database_.path(), "the record of reported events");
  }
  Statement last = database_.prepare("SELECT COALESCE(MAX(number), 0) FROM event");
  if (last.step()) last_event_ = static_cast<std::uint64_t>(last.integer(0));
}

std::uint64_t RunStore::close(events::RunEnd end) {
  // End the writer's thread, so that only this thread uses the connection.
  if (end.end != events::End::failed) writer_->group_commit.flush();
  writer_->group_commit.end();  // its thread uses writer_'s statements until here
  writer_.reset();
  end.epoch = epoch_;
  const SharedDatabase::Turn turn = connection_->turn();
  Statement current = database_.prepare("SELECT value FROM run WHERE key='epoch'");
  database_.execute("BEGIN IMMEDIATE");
  try {
    refuse_if_fenced(current);
    set_session(events::to_line(end));
    Statement row = database_.prepare(k_insert_event);
    insert_event(row, {.number = last_event_ + 1, .what = end});
    refuse_if_lock_is_lost();
    database_.execute("COMMIT");
    refuse_if_lock_is_lost();
  } catch (...) {
    roll_back(database_);
    throw;
  }
  if (database_.is_exclusive()) database_.empty_log();
  return ++last_event_;
}

void RunStore::insert_event(Statement& row, const events::RunEvent& event) const {
  const std::string line = events::to_line(event);
  row.bind(1, static_cast<std::int64_t>(event.number))
      .bind(2, line)
      .bind(3, checksum_of_event(salt_, event.number, line))
      .run();
}

void RunStore::refuse_if_lock_is_lost() const {
  if (lock_ != nullptr) lock_->check();
}

std::shared_ptr<SharedDatabase> RunStore::to_read() {
  if (database_.is_exclusive()) return connection_;
  return std::make_shared<SharedDatabase>(database_.path(), Access::read_only);
}

void RunStore::refuse_if_fenced(Statement& current_epoch) const {
  CHECK(current_epoch.step());
  const auto epoch = static_cast<std::uint64_t>(current_epoch.integer(0));
  current_epoch.reset();
  if (epoch == epoch_) return;
  throw base::Error(
      base::ExitCode::conflict,
      fmt::format(
          "{}: a newer session (epoch {}) has taken over this run; this session (epoch {}) stops",
          database_.path(), epoch, epoch_));
}

std::vector<ReplicaProgress> RunStore::progress() {
  const SharedDatabase::Turn turn = connection_->turn();
  Statement select = database_.prepare(
      "SELECT chain, replica, next_scan, state, checksum FROM replica ORDER BY chain, replica");
  std::vector<ReplicaProgress> all;
  while (select.step()) {
    const base::BytesView state = select.blob(3);
    ReplicaProgress replica{
        .replica = {base::ChainId{static_cast<std::uint32_t>(select.integer(0))},
                    base::ReplicaId{static_cast<std::uint32_t>(select.integer(1))}},
        .next_scan = static_cast<std::uint64_t>(select.integer(2)),
        .state = {state.begin(), state.end()}};
    const plan::ReplicaKey& key = replica.replica;
    if (checksum_of(salt_, key, replica.next_scan, base::BytesView(replica.state)) !=
        select.integer(4)) {
      refuse_damaged(database_.path(), fmt::format("the state of chain {}", select.integer(0)));
    }
    all.push_back(std::move(replica));
  }
  return all;
}

void RunStore::replay(plan::ReplicaKey replica, const ReplayVisit& visit) {
  std::uint64_t end = 0;
  {
    const SharedDatabase::Turn turn = connection_->turn();
    Statement next =
        database_.prepare("SELECT next_scan FROM replica WHERE chain=?1 AND replica=?2");
    next.bind(1, std::int64_t{replica.chain.value}).bind(2, std::int64_t{replica.replica.value});
    if (next.step()) end = static_cast<std::uint64_t>(next.integer(0));
  }
  const std::uint64_t reached = replay_rows(*connection_, salt_, replica, end, visit);
  if (reached != end) {
    refuse_damaged(database_.path(),
                   fmt::format("scan {} of chain {} is missing", reached, replica.chain.value));
  }
}

void RunStore::replay_all(const std::function<void(const plan::ReplicaKey&, base::ScanIndex,
                                                   std::span<const plan::ScanRecord>)>& visit) {
  for_each_stored(*connection_, visit);
}

void RunStore::put(plan::UnitResult result) {
  CHECK(writer_ != nullptr);
  writer_->group_commit.put(std::move(result));
}

void RunStore::put(PutEvents events) {
  CHECK(writer_ != nullptr);
  writer_->group_commit.put(std::move(events));
}

void RunStore::flush() {
  CHECK(writer_ != nullptr);
  writer_->group_commit.flush();
}

std::uint64_t RunStore::committed() const {
  CHECK(writer_ != nullptr);
  return writer_->group_commit.committed();
}

void RunStore::commit(GroupCommit::Group& group) {
  const SharedDatabase::Turn turn = connection_->turn();
  database_.execute("BEGIN IMMEDIATE");
  std::uint64_t last = last_event_;
  try {
    // Check the epoch (fencing). A session that was presumed dead must not write after its
    // successor has begun.
    refuse_if_fenced(writer_->current_epoch);
    for (const plan::UnitResult& result : group.results)
      insert(result);
    for (PutEvents& put : group.events) {
      for (events::RunEvent& event : put.events) {
        event.number = ++last;
        insert_event(writer_->insert_event, event);
      }
    }
    if (!group.events.empty()) set_told(group.events.back().reached);
    refuse_if_lock_is_lost();
    database_.execute("COMMIT");
    // Check the lock again. If the lock ended before the commit, the next holder's copy of the
    // store may lack the commit.
    refuse_if_lock_is_lost();
  } catch (...) {
    roll_back(database_);
    throw;
  }
  last_event_ = last;
  const std::scoped_lock lock(telling_);
  for (const PutEvents& put : group.events) {
    if (on_told_) on_told_(put.events);
  }
}

void RunStore::on_told(Told told) {
  const std::scoped_lock lock(telling_);
  on_told_ = std::move(told);
}

void RunStore::set_told(const ToldFrontier& reached) {
  const auto count = [](std::uint64_t value) { return static_cast<std::int64_t>(value); };
  writer_->set_told.bind(1, count(reached.scans))
      .bind(2, count(reached.starts))
      .bind(3, count(reached.solutions))
      .bind(4, count(reached.finds))
      .bind(5, count(reached.failures))
      .bind(6, checksum_of(salt_, reached))
      .run();
}

void RunStore::insert(const plan::UnitResult& result) {
  const auto chain = std::int64_t{result.unit.replica.chain.value};
  const auto replica = std::int64_t{result.unit.replica.replica.value};

  // Refuse a gap: a unit must continue or repeat stored scans.
  Statement& next = writer_->next_scan;
  next.bind(1, chain).bind(2, replica);
  const bool is_known = next.step();
  const std::int64_t next_scan = is_known ? next.integer(0) : 0;
  next.reset();
  // A replica that was added later begins at its chain's current scan.
  if (is_known || replica == 0)
    CHECK_LE(result.unit.first_scan.value, static_cast<std::uint64_t>(next_scan));

  auto scan = static_cast<std::int64_t>(result.unit.first_scan.value);
  Statement& row = writer_->insert_scan;
  for (const plan::ScanRecord& record : result.scans) {
    row.bind(1, chain).bind(2, replica).bind(3, scan++);
    row.bind(4, record.log_prior).bind(5, record.log_constraint);
    row.bind(6, record.inverse_temperature);
    row.bind(7, std::int64_t{record.satisfied ? 1 : 0});
    row.bind(8, static_cast<std::int64_t>(record.lineage));
    row.bind(9, base::bytes_of(std::span(record.proposed)));
    row.bind(10, base::bytes_of(std::span(record.accepted)));
    row.bind(11, base::bytes_of(std::span(record.outcome)));
    if (record.failures.total() == 0) {
      row.bind_null(12);
    } else {
      row.bind(12, base::bytes_of(std::span<const std::uint64_t>(record.failures.by_kind)));
    }
    row.bind(13, static_cast<std::int64_t>(record.overlapping_starts));
    if (record.method_values.empty()) {
      row.bind_null(14);
    } else {
      row.bind(14, base::bytes_of(std::span(record.method_values)));
    }
    if (record.state.empty()) {
      row.bind_null(15);
    } else {
      row.bind(15, base::BytesView(record.state));
    }
    row.bind(16,
             checksum_of(salt_, result.unit.replica, static_cast<std::uint64_t>(scan - 1), record));
    row.run();
  }
  writer_->advance_replica.bind(1, chain)
      .bind(2, replica)
      .bind(3, scan)
      .bind(4, base::BytesView(result.state_after))
      .bind(5, checksum_of(salt_, result.unit.replica, static_cast<std::uint64_t>(scan),
                           base::BytesView(result.state_after)))
      .run();
}

}  // namespace sleight::store
