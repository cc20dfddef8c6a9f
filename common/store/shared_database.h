// A database connection at which several threads take turns.
//
// On a local disk SQLite lets any number of connections read beside one that writes. On a network
// disk there is no memory that they could share, so a process has a single connection for all:
// group commits and readers take turns. Turns come in the order in which they were asked for, so
// that a commit waits for one turn at most of every other thread; a reader takes one for some rows,
// and visits them afterwards.
//
// Invariants
//   1. Between turns no statement is being stepped and no transaction is open.
//   2. A turn calls nobody that might ask for another.
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
  /// One that holds a run's lock as long as it lives.
  SharedDatabase(std::unique_ptr<RunLock> lock, const std::string& path, Access access);
  SharedDatabase(const SharedDatabase&) = delete;
  SharedDatabase& operator=(const SharedDatabase&) = delete;

  /// The connection is the calling thread's as long as the object lives.
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
  /// For whoever owns it and takes turns itself, or while it is alone with it.
  Database& only_database() { return database_; }

 private:
  std::unique_ptr<RunLock> lock_;  // first: it goes last
  Database database_;
  std::mutex mutex_;  ///< of all below
  std::condition_variable changed_;
  std::uint64_t asked_ = 0;
  std::uint64_t served_ = 0;
};

/// The store of a run, for a process that does not write it. On a local disk that is a connection
/// of its own, beside a writer. On a network disk it takes the run's lock as long as it lives, and
/// where that is held throws base::Error(conflict) that says why and names the latest archive.
std::shared_ptr<SharedDatabase> open_to_read(const std::string& folder);

/// The archive that a run itself writes, however its folder is named; "" where it can't be told.
std::string own_archive_of(const std::string& folder);

}  // namespace sleight::store
