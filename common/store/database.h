// A small RAII shell over SQLite's C interface: every return value is looked at, every failure is
// a base::Error naming the file, the reason and what to do.
//
// Thread safety: one connection is used by one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/bytes.h"
#include "common/base/error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace sleight::store {

/// A prepared statement; borrowed from its Database, which must outlive it.
class Statement {
 public:
  Statement(sqlite3* connection, const std::string& path, std::string_view sql);

  Statement& bind(int index, std::int64_t value);
  Statement& bind(int index, double value);  ///< not NaN, which SQLite turns into NULL
  Statement& bind(int index, std::string_view value);
  /// The bytes must live until the statement is stepped or reset; nothing is copied.
  Statement& bind(int index, base::BytesView value);
  Statement& bind_null(int index);

  /// Whether there is a row to read.
  bool step();
  /// For statements that return nothing: steps once and resets, also when it throws.
  void run();
  void reset();

  std::int64_t integer(int column) const;
  double real(int column) const;
  std::string text(int column) const;
  /// Valid until the next step or reset.
  base::BytesView blob(int column) const;

 private:
  void check(int code) const;

  sqlite3* connection_;
  std::string path_;
  std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> statement_;
};

enum class Access { read_only, read_write };

/// SQLite's failure: base::Error with what a run store's user should do, and for those who do
/// something else the kind and the bare reason.
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
  /// Opens a file, and with read_write makes it if need be, in WAL mode with synchronous=FULL:
  /// after COMMIT returns, the rows survive kill -9 and loss of power. With read_write on a network
  /// disk it is the file's only connection, in all processes: SQLite then shares no memory, and
  /// where the disk has no locks (fcntl), the caller's own is the only one. Its log then stays when
  /// it is closed: a process whose lock has been taken over would remove its successor's by name.
  Database(const std::string& path, Access access);
  /// Whether it is the only connection that there may be.
  bool is_exclusive() const { return is_exclusive_; }
  /// Moves the log into the file, as closing does where others may connect.
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
