// Replaces files that a process on another machine may still write, when its lock is taken over
// (RunLock::owes_copies).
//
// A writer may stall in the middle of a commit and continue after its lease has ended. The old
// writer would then overwrite its successor's pages, and no lock on a network disk can prevent
// that. However, the old writer writes to the file that it has opened, not to the copy that now has
// the name.
//
// A copied database with its log is consistent even if the old writer continues meanwhile, because
// the old writer finishes at most one commit (RunLock::check refuses the next):
//   1. The database is copied before its log. A page that a checkpoint moved into the database was
//      in the log before, and stays there until the next commit.
//   2. A commit only partly in the copied log does not count, because its frames have checksums.
//   3. The copied database gets its name before its log. Whichever log is beside it, the old one or
//      the copy, contains what the database lacks.
// So the copy contains every commit after which the old writer could still check its lease.
#pragma once

#include <string>

#include "common/store/run_lock.h"

namespace sleight::store {

/// Replaces a run's database and log by copies and removes cached motions. Renews the lock
/// meanwhile. May be repeated after a process was killed during the replacement. Throws base::Error
/// if the disk fails, without losing anything. REQUIRES: the lock is held, and the store is closed.
void replace_files_of_run(const std::string& folder, RunLock& lock);

}  // namespace sleight::store
