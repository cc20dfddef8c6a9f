#include "common/store/database.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>

#include "common/base/check.h"
#include "common/base/file_system.h"
#include "common/base/network_disk.h"
#include "common/store/damage.h"

namespace sleight::store {
namespace {

constexpr int k_busy_timeout_ms = 10'000;

DatabaseError::Kind kind_of(int basic_code) {
  switch (basic_code) {
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
      return DatabaseError::Kind::damaged;
    case SQLITE_FULL:
      return DatabaseError::Kind::full;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return DatabaseError::Kind::busy;
    default:
      return DatabaseError::Kind::other;
  }
}

[[noreturn]] void fail(sqlite3* connection, const std::string& path, int code) {
  const int basic = code & 0xff;
  std::string advice;
  if (basic == SQLITE_FULL) advice = "; free disk space, then run the same command again to resume";
  if (basic == SQLITE_IOERR) advice = "; check the disk, then run the same command again to resume";
  if (basic == SQLITE_CANTOPEN) advice = "; check that the folder exists and can be written";
  if (basic == SQLITE_NOTADB || basic == SQLITE_CORRUPT) {
    advice = fmt::format("; {}; use --fresh or another output", k_no_store_words);
  }
  const char* reason = connection != nullptr ? sqlite3_errmsg(connection) : sqlite3_errstr(code);
  throw DatabaseError(fmt::format("{}: {}{}", path, reason, advice), kind_of(basic), reason);
}

/// Returns whether the database must be opened as immutable. SQLite needs a log even for reading,
/// unless the database is immutable. The result is true if there is no log and this process can't
/// create one.
bool nobody_can_write(const std::string& path) {
  const std::string folder = base::directory_of(path);
  return ::access((path + "-wal").c_str(), F_OK) != 0 && ::access(folder.c_str(), W_OK) != 0;
}

/// Creates the file with the umask's permissions. If SQLite created the file, only its owner could
/// write it. SQLite's other files get the same mode as this file.
void make_file(const std::string& path) {
  const int made = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (made >= 0) ::close(made);
}

/// Returns whether the disk supports locks. Lustre may be mounted without locks, and NFS may lack
/// its lock server. REQUIRES: this process has no connection to the file, because closing this
/// descriptor would release the connection's locks.
bool has_file_locks(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return true;  // SQLite will report the reason
  struct flock asked {};
  asked.l_type = F_WRLCK;
  asked.l_whence = SEEK_SET;
  const bool fails = ::fcntl(descriptor, F_GETLK, &asked) != 0;
  const int reason = errno;
  ::close(descriptor);
  return !fails || (reason != ENOSYS && reason != ENOLCK && reason != EOPNOTSUPP);
}

/// Returns the path as a URI for SQLite, with special characters escaped.
std::string uri_of(const std::string& path) {
  std::string uri = "file:";
  for (const char character : path) {
    if (character == '%' || character == '?' || character == '#') {
      uri += fmt::format("%{:02x}", static_cast<unsigned char>(character));
    } else {
      uri += character;
    }
  }
  return uri;
}

}  // namespace

Statement::Statement(sqlite3* connection, const std::string& path, std::string_view sql)
    : connection_(connection), path_(path), statement_(nullptr, &sqlite3_finalize) {
  sqlite3_stmt* statement = nullptr;
  check(sqlite3_prepare_v2(connection, sql.data(), static_cast<int>(sql.size()), &statement,
                           nullptr));
  statement_.reset(statement);
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) fail(connection_, path_, code);
}

Statement& Statement::bind(int index, std::int64_t value) {
  check(sqlite3_bind_int64(statement_.get(), index, value));
  return *this;
}

Statement& Statement::bind(int index, double value) {
  CHECK(value == value);
  check(sqlite3_bind_double(statement_.get(), index, value));
  return *this;
}

Statement& Statement::bind(int index, std::string_view value) {
  check(sqlite3_bind_text64(statement_.get(), index, value.data(), value.size(), SQLITE_TRANSIENT,
                            SQLITE_UTF8));
  return *this;
}

Statement& Statement::bind(int index, base::BytesView value) {
  // Use a non-null address for an empty blob, because a null pointer would bind NULL.
  const void* data = value.empty() ? static_cast<const void*>("") : value.data();
  check(sqlite3_bind_blob64(statement_.get(), index, data, value.size(), SQLITE_STATIC));
  return *this;
}

Statement& Statement::bind_null(int index) {
  check(sqlite3_bind_null(statement_.get(), index));
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  fail(connection_, path_, code);
}

void Statement::run() {
  const int code = sqlite3_step(statement_.get());
  const int reset_code = sqlite3_reset(statement_.get());
  if (code != SQLITE_DONE) fail(connection_, path_, code);
  check(reset_code);
}

void Statement::reset() {
  check(sqlite3_reset(statement_.get()));
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

double Statement::real(int column) const {
  return sqlite3_column_double(statement_.get(), column);
}

std::string Statement::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return text == nullptr ? std::string() : std::string(text, size);
}

base::BytesView Statement::blob(int column) const {
  const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(statement_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return bytes == nullptr ? base::BytesView() : base::BytesView(bytes, size);
}

Database::Database(const std::string& path, Access access)
    : path_(path), connection_(nullptr, &sqlite3_close_v2) {
  const int flags = access == Access::read_only ? SQLITE_OPEN_READONLY
                                                : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  const bool is_still = access == Access::read_only && nobody_can_write(path);
  const std::string name = is_still ? uri_of(path) + "?immutable=1" : path;
  is_exclusive_ = access == Access::read_write &&
                  base::network_file_system(base::directory_of(path)).has_value();
  if (access == Access::read_write) make_file(path);
  const char* const disk = is_exclusive_ && !has_file_locks(path) ? "unix-none" : nullptr;
  sqlite3* connection = nullptr;
  const int code =
      sqlite3_open_v2(name.c_str(), &connection, is_still ? flags | SQLITE_OPEN_URI : flags, disk);
  connection_.reset(connection);
  if (code != SQLITE_OK) fail(connection, path, code);
  sqlite3_extended_result_codes(connection, 1);
  sqlite3_busy_timeout(connection, k_busy_timeout_ms);
  // Don't run a hostile schema's functions in views and triggers.
  sqlite3_db_config(connection, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  if (access == Access::read_write) set_write_mode();
}

void Database::set_write_mode() {
  if (is_exclusive_) {
    // Set the mode before accessing the log. Otherwise the log's index would be in shared memory.
    execute("PRAGMA locking_mode=EXCLUSIVE");
    sqlite3_db_config(connection_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  }
  Statement mode = prepare("PRAGMA journal_mode=WAL");
  // Check the mode, because SQLite may silently use another one. In other modes SQLite removes its
  // journal by name.
  if (const bool is_log = mode.step() && mode.text(0) == "wal"; is_exclusive_ && !is_log) {
    throw base::Error(fmt::format(
        "{}: SQLite can't use a write-ahead log on this disk; put the run on another disk", path_));
  }
  mode.reset();
  execute("PRAGMA synchronous=FULL");
  // A checkpoint needs seeks. So make checkpoints less often than the default, every 1,000 pages.
  execute("PRAGMA wal_autocheckpoint=4000");
}

void Database::empty_log() {
  execute("PRAGMA wal_checkpoint(TRUNCATE)");
}

void Database::execute(const std::string& sql) {
  if (const int code = sqlite3_exec(connection_.get(), sql.c_str(), nullptr, nullptr, nullptr);
      code != SQLITE_OK) {
    fail(connection_.get(), path_, code);
  }
}

Statement Database::prepare(std::string_view sql) {
  return Statement(connection_.get(), path_, sql);
}

}  // namespace sleight::store
