#include "service/daemon/job_store.h"

#include <fmt/format.h>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/json/value.h"
#include "common/store/checksum.h"
#include "service/daemon/job_records.h"

namespace sleight::daemon {
namespace {

constexpr const char* k_tables = R"(
CREATE TABLE state(key TEXT PRIMARY KEY, value TEXT NOT NULL, checksum INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE job(id INTEGER PRIMARY KEY, record TEXT NOT NULL, checksum INTEGER NOT NULL);
CREATE TABLE change(job INTEGER, number INTEGER, record TEXT NOT NULL, checksum INTEGER NOT NULL,
                    PRIMARY KEY(job, number)) WITHOUT ROWID;
CREATE TABLE request(job INTEGER, revision INTEGER, asked TEXT NOT NULL, text TEXT NOT NULL,
                     checksum INTEGER NOT NULL, asked_checksum INTEGER NOT NULL,
                     PRIMARY KEY(job, revision));
CREATE TABLE usage(user INTEGER PRIMARY KEY, record TEXT NOT NULL, checksum INTEGER NOT NULL);
)";

constexpr const char* k_put_back =
    "Restore the state folder from a backup, or move it away and start with an empty one";

/// A row's address: its table and up to two numbers.
struct Place {
  const char* table;
  std::uint64_t first = 0;
  std::uint64_t second = 0;
};

std::int64_t checksum_of(const Place& place, std::string_view text) {
  return store::checksum_of_text(fmt::format("{}/{}/{}", place.table, place.first, place.second),
                                 text);
}

/// Throws if the text isn't what was written at this place.
void verify(const store::Database& database, const Place& place, std::string_view text,
            std::int64_t checksum) {
  if (checksum_of(place, text) == checksum) return;
  throw base::Error(
      fmt::format("{}: row ({}, {}) of table {} has a wrong checksum, because the disk failed or "
                  "another program changed the file; the store was not changed. {}",
                  database.path(), place.first, place.second, place.table, k_put_back));
}

template <class Value>
Value sound(std::optional<Value> value, const store::Database& database, const Place& place) {
  if (value) return *std::move(value);
  throw base::Error(fmt::format("{}: can't parse row ({}, {}) of table {}", database.path(),
                                place.first, place.second, place.table));
}

std::uint64_t number_of(store::Statement& statement, int column) {
  return static_cast<std::uint64_t>(statement.integer(column));
}

std::int64_t signed_of(std::uint64_t value) {
  CHECK_LE(value, std::uint64_t{INT64_MAX});
  return static_cast<std::int64_t>(value);
}

std::string asked_line(const StoredRequest& request) {
  json::Value json{{"found_wanted", request.found_wanted},
                   {"in_proportion_wanted", request.in_proportion_wanted}};
  if (!request.options.empty()) json["options"] = request.options;
  json["strict"] = request.strict;
  if (!request.token_id.empty()) json["token"] = request.token_id;
  json["world"] = request.world;
  return json.dump();
}

std::optional<StoredRequest> asked_of(std::string_view line) {
  try {
    const auto json = json::Value::parse(line);
    return StoredRequest{
        .world = json.at("world").text(),
        .strict = json.at("strict").get<bool>(),
        .found_wanted = json.at("found_wanted").get<std::uint64_t>(),
        .in_proportion_wanted = json.at("in_proportion_wanted").get<std::uint64_t>(),
        .token_id = json.value("token", ""),
        .options = json.value("options", std::map<std::string, std::string>())};
  } catch (const json::Error&) {
    return std::nullopt;
  }
}

Place place_of_text(jobs::JobId job, std::uint64_t revision) {
  return {.table = "request", .first = job.value, .second = revision};
}

Place place_of_asked(jobs::JobId job, std::uint64_t revision) {
  return {.table = "request.asked", .first = job.value, .second = revision};
}

}  // namespace

namespace {

/// Runs `work`. If the file is damaged, adds advice about job stores to the error.
template <class Work>
auto with_advice(const std::string& path, const Work& work) {
  try {
    return work();
  } catch (const store::DatabaseError& error) {
    if (error.kind() != store::DatabaseError::Kind::damaged) throw;
    throw base::Error(
        fmt::format("{}: the job store is damaged ({}); the store was not changed. {}", path,
                    error.reason(), k_put_back));
  }
}

}  // namespace

JobStore::JobStore(const std::string& path, const store::RunLock* lock)
    : shared_(with_advice(path,
                          [&] {
                            return std::make_shared<store::SharedDatabase>(
                                path, store::Access::read_write);
                          })),
      database_(shared_->only_database()),
      lock_(lock) {
  const store::SharedDatabase::Turn turn = shared_->turn();
  with_advice(path, [&] { create_or_check(); });
}

std::shared_ptr<store::SharedDatabase> JobStore::to_read() const {
  if (database_.is_exclusive()) return shared_;
  return std::make_shared<store::SharedDatabase>(database_.path(), store::Access::read_only);
}

void JobStore::create_or_check() {
  bool is_new = false;
  {
    store::Statement tables = database_.prepare("SELECT count(*) FROM sqlite_master");
    tables.step();
    is_new = tables.integer(0) == 0;
  }
  if (is_new) {
    database_.execute("BEGIN IMMEDIATE");
    database_.execute(k_tables);
    set_state("format", std::to_string(k_job_store_format));
    set_state("clock_s", "0");
    set_state("next_id", "1");
    database_.execute("COMMIT");
    return;
  }
  const std::string format = state_value("format");
  if (format == std::to_string(k_job_store_format)) return;
  throw base::Error(base::ExitCode::conflict,
                    fmt::format("{}: the job store has format {}, expected {}; use the program "
                                "version that created the store, or another state folder",
                                database_.path(), format, k_job_store_format));
}

std::string JobStore::state_value(std::string_view key) {
  store::Statement select = database_.prepare("SELECT value, checksum FROM state WHERE key = ?");
  select.bind(1, key);
  if (!select.step())
    throw base::Error(base::ExitCode::conflict,
                      fmt::format("{}: not a Sleight job store", database_.path()));
  std::string value = select.text(0);
  if (store::checksum_of_text(key, value) != select.integer(1))
    throw base::Error(
        fmt::format("{}: the value of '{}' has a wrong checksum; the store was not changed",
                    database_.path(), key));
  return value;
}

void JobStore::set_state(std::string_view key, std::string_view value) {
  store::Statement put = database_.prepare("INSERT OR REPLACE INTO state VALUES(?, ?, ?)");
  put.bind(1, key).bind(2, value).bind(3, store::checksum_of_text(key, value)).run();
}

StoredJobs JobStore::load() {
  const store::SharedDatabase::Turn turn = shared_->turn();
  StoredJobs loaded;
  store::Statement rows = database_.prepare("SELECT id, record, checksum FROM job ORDER BY id");
  while (rows.step()) {
    const Place place{.table = "job", .first = number_of(rows, 0)};
    const std::string line = rows.text(1);
    verify(database_, place, line, rows.integer(2));
    loaded.jobs.push_back(sound(job_of(line), database_, place));
  }
  store::Statement users = database_.prepare("SELECT user, record, checksum FROM usage");
  while (users.step()) {
    const Place place{.table = "usage", .first = number_of(users, 0)};
    const std::string line = users.text(1);
    verify(database_, place, line, users.integer(2));
    loaded.usages.push_back(sound(usage_of(line), database_, place));
  }
  store::Statement requests = database_.prepare(
      "SELECT job, max(revision), asked, asked_checksum FROM request GROUP BY job ORDER BY job");
  while (requests.step()) {
    const jobs::JobId job{number_of(requests, 0)};
    const std::uint64_t revision = number_of(requests, 1);
    const Place place = place_of_asked(job, revision);
    const std::string line = requests.text(2);
    verify(database_, place, line, requests.integer(3));
    StoredRequest request = sound(asked_of(line), database_, place);
    request.job = job;
    request.revision = revision;
    loaded.requests.push_back(std::move(request));
  }
  store::Statement changes = database_.prepare("SELECT job, max(number) FROM change GROUP BY job");
  while (changes.step())
    loaded.change_counts[jobs::JobId{number_of(changes, 0)}] = number_of(changes, 1);
  loaded.clock_s = std::strtod(state_value("clock_s").c_str(), nullptr);
  loaded.next_id = std::strtoull(state_value("next_id").c_str(), nullptr, 10);
  return loaded;
}

void JobStore::save(std::span<const Save* const> saves) {
  if (saves.empty()) return;
  const store::SharedDatabase::Turn turn = shared_->turn();
  const auto refuse_if_lock_is_lost = [&] {
    if (lock_ != nullptr) lock_->check();
  };
  database_.execute("BEGIN IMMEDIATE");
  try {
    for (const Save* save : saves)
      put(*save);
    set_state("clock_s", fmt::format("{}", saves.back()->jobs.clock_s));
    set_state("next_id", fmt::format("{}", saves.back()->jobs.next_id));
    refuse_if_lock_is_lost();
    database_.execute("COMMIT");
    refuse_if_lock_is_lost();
  } catch (...) {
    try {
      database_.execute("ROLLBACK");
    } catch (const base::Error&) {
      // SQLite may already have rolled back, for example because the disk is full.
    }
    throw;
  }
}

void JobStore::empty_log() {
  const store::SharedDatabase::Turn turn = shared_->turn();
  if (lock_ != nullptr) lock_->check();
  database_.empty_log();
}

void JobStore::put(const Save& save) {
  store::Statement job_row = database_.prepare("INSERT OR REPLACE INTO job VALUES(?, ?, ?)");
  for (const jobs::Job& job : save.jobs.jobs) {
    const std::string line = to_line(job);
    job_row.bind(1, signed_of(job.id.value))
        .bind(2, std::string_view(line))
        .bind(3, checksum_of({.table = "job", .first = job.id.value}, line))
        .run();
  }
  store::Statement last =
      database_.prepare("SELECT coalesce(max(number), 0) FROM change WHERE job = ?");
  store::Statement change_row = database_.prepare("INSERT INTO change VALUES(?, ?, ?, ?)");
  for (const jobs::Change& change : save.jobs.changes) {
    last.bind(1, signed_of(change.id.value)).step();
    const std::uint64_t number = number_of(last, 0) + 1;
    last.reset();
    const std::string line = to_line(change);
    const Place place{.table = "change", .first = change.id.value, .second = number};
    change_row.bind(1, signed_of(change.id.value))
        .bind(2, signed_of(number))
        .bind(3, std::string_view(line))
        .bind(4, checksum_of(place, line))
        .run();
  }
  store::Statement usage_row = database_.prepare("INSERT OR REPLACE INTO usage VALUES(?, ?, ?)");
  for (const jobs::Usage& usage : save.jobs.usages) {
    const std::string line = to_line(usage);
    usage_row.bind(1, signed_of(usage.user.value))
        .bind(2, std::string_view(line))
        .bind(3, checksum_of({.table = "usage", .first = usage.user.value}, line))
        .run();
  }
  put_requests(save);
  for (const jobs::JobId job : save.jobs.erased)
    erase(job);
}

void JobStore::put_requests(const Save& save) {
  store::Statement row =
      database_.prepare("INSERT OR REPLACE INTO request VALUES(?, ?, ?, ?, ?, ?)");
  for (const StoredRequest& request : save.requests) {
    const std::string asked = asked_line(request);
    row.bind(1, signed_of(request.job.value))
        .bind(2, signed_of(request.revision))
        .bind(3, std::string_view(asked))
        .bind(4, std::string_view(request.text))
        .bind(5, checksum_of(place_of_text(request.job, request.revision), request.text))
        .bind(6, checksum_of(place_of_asked(request.job, request.revision), asked))
        .run();
  }
}

void JobStore::erase(jobs::JobId job) {
  for (const char* sql : {"DELETE FROM job WHERE id = ?", "DELETE FROM change WHERE job = ?",
                          "DELETE FROM request WHERE job = ?"}) {
    database_.prepare(sql).bind(1, signed_of(job.value)).run();
  }
}

std::vector<JobReader::NumberedChange> JobReader::changes(jobs::JobId job, std::uint64_t from,
                                                          std::size_t count_max) {
  const store::SharedDatabase::Turn turn = shared_->turn();
  store::Database& database = *turn;
  store::Statement rows = database.prepare(
      "SELECT number, record, checksum FROM change WHERE job = ? AND number >= ? "
      "ORDER BY number LIMIT ?");
  rows.bind(1, signed_of(job.value))
      .bind(2, signed_of(from))
      .bind(3, signed_of(static_cast<std::uint64_t>(count_max)));
  std::vector<NumberedChange> changes;
  while (rows.step()) {
    const Place place{.table = "change", .first = job.value, .second = number_of(rows, 0)};
    const std::string line = rows.text(1);
    verify(database, place, line, rows.integer(2));
    changes.push_back({.number = place.second, .change = sound(change_of(line), database, place)});
  }
  return changes;
}

std::uint64_t JobReader::change_count(jobs::JobId job) {
  const store::SharedDatabase::Turn turn = shared_->turn();
  store::Database& database = *turn;
  store::Statement select =
      database.prepare("SELECT coalesce(max(number), 0) FROM change WHERE job = ?");
  select.bind(1, signed_of(job.value)).step();
  return number_of(select, 0);
}

std::optional<StoredRequest> JobReader::request(jobs::JobId job, std::uint64_t revision) {
  const store::SharedDatabase::Turn turn = shared_->turn();
  store::Database& database = *turn;
  store::Statement row = database.prepare(
      "SELECT asked, asked_checksum, text, checksum FROM request WHERE job = ? AND revision = ?");
  row.bind(1, signed_of(job.value)).bind(2, signed_of(revision));
  if (!row.step()) return std::nullopt;
  const std::string asked = row.text(0);
  verify(database, place_of_asked(job, revision), asked, row.integer(1));
  StoredRequest request = sound(asked_of(asked), database, place_of_asked(job, revision));
  request.job = job;
  request.revision = revision;
  request.text = row.text(2);
  verify(database, place_of_text(job, revision), request.text, row.integer(3));
  return request;
}

}  // namespace sleight::daemon
