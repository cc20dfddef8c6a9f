// When a lock is taken over, replaces the files that the old holder on another machine may still
// write (RunLock::owes_copies).
//
// A writer may stall in the middle of a commit and continue after its lease has ended. The old
// writer would then overwrite its successor's pages, which no lock on a network disk can prevent.
// However, the old writer writes to the file that it has opened, not to the copy that now has the
// name.
//
// A copied database with its log is consistent even if the old writer continues meanwhile, because
// the old writer finishes at most one commit (RunLock::check refuses the next):
//   1. The database is copied before its log. If a checkpoint moves a page into the database, the
//      log still contains the page until the next commit.
//   2. A commit that is only partly in the copied log does not count, because frames have
//      checksums.
//   3. The copied database gets its name before its log. The log beside it, whether the old one or
//      the copy, contains the pages that the database lacks.
// So the copy contains every commit after which the old writer could still check its lease.
#pragma once

#include <string>

#include "common/store/run_lock.h"

namespace sleight::store {

/// Replaces a run's database and log by copies and removes cached motions. Renews the lock
/// meanwhile. Can be called again after a process was killed during the replacement. Throws
/// base::Error if the disk fails, without losing anything. REQUIRES: the lock is held, and the
/// store is closed.
void replace_files_of_run(const std::string& folder, RunLock& lock);

}  // namespace sleight::store
