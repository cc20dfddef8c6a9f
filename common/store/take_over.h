// If a lock's old holder was on another machine, it may still write its files
// (RunLock::owes_copies). When the lock is taken over, this code replaces these files.
//
// A writer may stall in the middle of a commit and continue after its lease has ended. The old
// writer would then overwrite its successor's pages. No lock on a network disk can prevent this.
// However, the old writer writes to the file that it has opened. The successor uses a copy, which
// now has the file's name.
//
// The copies of database and log are consistent even if the old writer continues during the
// copying. The old writer finishes at most one commit (RunLock::check refuses the next):
//   1. The database is copied before its log. If a checkpoint moves a page into the database, the
//      log still contains the page until the next commit.
//   2. If the copied log has only a part of a commit, this commit does not count, because frames
//      have checksums.
//   3. The copied database is renamed before the copied log. So the log beside the copied database
//      is the old log or the copy. The old log and the copy both contain the pages that the
//      database lacks.
// So the copy contains every commit after which the old writer could still check its lease.
#pragma once

#include <string>

#include "common/store/run_lock.h"

namespace sleight::store {

/// Replaces a run's database and log by copies, and removes cached motions. Renews the lock
/// meanwhile. If the process is killed during the replacement, another can call this function
/// again. If the disk fails, throws base::Error; nothing is lost. REQUIRES: the lock is held, and
/// the store is closed.
void replace_files_of_run(const std::string& folder, RunLock& lock);

}  // namespace sleight::store
