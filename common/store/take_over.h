// Files that a process on another machine may still write are replaced by copies, when the lock is
// taken from it (RunLock::owes_copies).
//
// A writer that stands still in the middle of a commit, and goes on after its lease has ended,
// would write into the pages of its successor: no lock on a network disk can prevent that. It
// writes into the file that it has opened, though, and not into the copy that has got its name.
//
// A copy of a database with its log is one, though the old writer may go on meanwhile, since that
// is with one commit at most (RunLock::check refuses the next):
//   1. The database is copied before its log. A page that a checkpoint has moved into the database
//      was in the log before, and stays there until the next commit.
//   2. A commit that is half in the copied log is none: its frames carry checksums.
//   3. The database gets its name before its log: whichever log lies beside it, the old or the
//      copied, has what the database lacks.
// So a commit after which the old writer could still check its lease is in the copy.
#pragma once

#include <string>

#include "common/store/run_lock.h"

namespace sleight::store {

/// Replaces a run's database and its log by copies; motions are forgotten. Renews the lock as it
/// goes. May be called again where a process was killed in it. Throws base::Error where the disk
/// fails; then nothing is lost. REQUIRES: the lock is held, and the store isn't open.
void replace_files_of_run(const std::string& folder, RunLock& lock);

}  // namespace sleight::store
