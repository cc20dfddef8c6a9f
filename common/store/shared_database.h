// A database connection that several threads use in turns.
//
// On a local disk, SQLite allows any number of reading connections beside a writing one. On a
// network disk, connections can't share memory. So the process then has a single connection. Group
// commits and readers use this connection in turns. Turns are granted in the order of requests. So
// a commit waits for at most one turn of each other thread. A reader reads a batch of rows in one
// turn, and visits the rows after the turn.
//
// Invariants
//   1. Between turns no statement is active and no transaction is open.
//   2. Code that has a turn must not call functions that may take a turn.
// Thread-safe.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "common/store/database.h"
#include "common/store/run_lock.h"

namespace sleight::store {

class SharedDatabase {
 public:
  SharedDatabase(const std::string& path, Access access);
  /// A connection that holds a run's lock during its life.
  SharedDatabase(std::unique_ptr<RunLock> lock, const std::string& path, Access access);
  SharedDatabase(const SharedDatabase&) = delete;
  SharedDatabase& operator=(const SharedDatabase&) = delete;

  /// Reserves the connection for the calling thread during the object's life.
  class Turn {
   public:
    explicit Turn(SharedDatabase& shared);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    Database* operator->() const { return &shared_.database_; }
    Database& operator*() const { return shared_.database_; }

   private:
    SharedDatabase& shared_;
  };
  [[nodiscard]] Turn turn() { return Turn(*this); }
  const std::string& path() const { return database_.path(); }
  /// For an owner that takes turns itself, or is the only user.
  Database& only_database() { return database_; }

 private:
  std::unique_ptr<RunLock> lock_;  // first member, so destroyed last
  Database database_;
  std::mutex mutex_;  ///< guards all members below
  std::condition_variable changed_;
  std::uint64_t asked_ = 0;
  std::uint64_t served_ = 0;
};

/// Opens a run's store in a process that does not write it. On a local disk this is a separate
/// connection, and a writer may be active. On a network disk the connection holds the run's lock
/// during its life. If another process has the lock, throws base::Error(conflict) with the reason
/// and the latest archive.
std::shared_ptr<SharedDatabase> open_to_read(const std::string& folder);

/// Returns the path of the archive that the run itself writes; "" if unknown.
std::string own_archive_of(const std::string& folder);

}  // namespace sleight::store
