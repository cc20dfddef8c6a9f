// A small RAII wrapper of SQLite's C interface. The wrapper checks every return value. On failure,
// it throws a base::Error that names the file, the reason and what to do.
//
// Thread safety: only one thread at a time may use a connection.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/bytes.h"
#include "common/base/error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace sleight::store {

/// A prepared statement. The Database must outlive its statements.
class Statement {
 public:
  Statement(sqlite3* connection, const std::string& path, std::string_view sql);

  Statement& bind(int index, std::int64_t value);
  Statement& bind(int index, double value);  ///< not NaN, which SQLite stores as NULL
  Statement& bind(int index, std::string_view value);
  /// Binds without copying: the bytes must live until the next step() or reset().
  Statement& bind(int index, base::BytesView value);
  Statement& bind_null(int index);

  /// Returns whether a row is available.
  bool step();
  /// Executes a statement that returns no rows: steps once, then resets. Resets even if the step
  /// throws.
  void run();
  void reset();

  std::int64_t integer(int column) const;
  double real(int column) const;
  std::string text(int column) const;
  /// The bytes are valid until the next step() or reset().
  base::BytesView blob(int column) const;

 private:
  void check(int code) const;

  sqlite3* connection_;
  std::string path_;
  std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> statement_;
};

enum class Access { read_only, read_write };

/// A failure of SQLite. The base::Error's message has advice for users of run stores. Other callers
/// use kind() and reason(); the reason contains no advice.
class DatabaseError : public base::Error {
 public:
  enum class Kind { damaged, full, busy, other };
  DatabaseError(const std::string& message, Kind kind, std::string reason)
      : base::Error(message), kind_(kind), reason_(std::move(reason)) {}
  Kind kind() const { return kind_; }
  const std::string& reason() const { return reason_; }

 private:
  Kind kind_;
  std::string reason_;
};

class Database {
 public:
  /// Opens a file in WAL mode and with synchronous=FULL. So once COMMIT has returned, the rows
  /// survive kill -9 and power loss. read_write creates a missing file. On a network disk, a
  /// read_write connection must be the file's only connection in all processes, because SQLite then
  /// uses no shared memory. If the disk lacks file locks (fcntl), only the caller's lock excludes
  /// other connections. On a network disk, closing a connection doesn't delete the log. Otherwise a
  /// process that has lost its lock could delete its successor's log.
  Database(const std::string& path, Access access);
  /// Returns whether this connection must be the file's only one.
  bool is_exclusive() const { return is_exclusive_; }
  /// Moves the log's contents into the file. Closing a connection also empties the log, unless the
  /// connection is exclusive.
  void empty_log();

  void execute(const std::string& sql);
  Statement prepare(std::string_view sql);
  const std::string& path() const { return path_; }

 private:
  void set_write_mode();

  std::string path_;
  bool is_exclusive_ = false;
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> connection_;
};

}  // namespace sleight::store
