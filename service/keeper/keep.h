// The keeper: one process per attempt that starts the job's program and records how it ends.
//
//   1. Takes the folder's lock. Exits if the lock is taken, or if the folder's record is of this
//      attempt or a later attempt. So an attempt that is launched twice runs once.
//   2. Removes the remains of a killed attempt, creates the pipe on which the program reports its
//      session's end (common/events/run_end.h), and writes the attempt's record.
//   3. Starts the program (program.h) and waits. Meanwhile the keeper writes the program's output
//      to the bounded log, and handles signals:
//        `SIGUSR1`, `SIGINT`: send SIGUSR1 to the program, which stops a run cleanly.
//        `SIGTERM`: kill the program and all its descendants.
//        `SIGHUP`: ignore.
//      The keeper kills a program that reported its end but doesn't exit, and an mpirun whose ranks
//      have all exited (Debian 12's mpirun sometimes hangs while exiting).
//   4. After the program has ended, kills its remaining descendants. The keeper is their subreaper,
//      so it can wait for all of them.
//   5. Writes the record with the end. If the pipe reported no end, the keeper uses the end of this
//      attempt's session in the run store, if any.
//
// In a batch system's job (KeeperOptions::in_batch) five things differ:
//
//   1. The system sends SIGTERM to all processes some time before killing them. The keeper forwards
//      SIGTERM as SIGUSR1. The program itself blocks SIGTERM, so it doesn't receive two signals.
//   2. The program gets the whole environment, from which mpirun finds the job's machines.
//   3. On a network disk, whose locks outlive a lost machine, the file `begun.N` replaces the lock.
//      So an attempt that the system starts twice runs once.
//   4. A second keeper on the same machine waits until the first one exits, because the system
//      would interpret the second keeper's exit as the end of the job.
//   5. A keeper that was presumed lost doesn't overwrite a later attempt's record.
//
// Invariants:
//   1. The keeper holds the lock while it lives, and no process of the program outlives the keeper,
//      because the keeper waits for all of them. If the keeper is killed, the kernel kills the
//      program, and the program's death ends its ranks (clients/cli/end_with_mpirun.h).
//   2. The record of the end is written after all processes of the program ended.
//
// Thread safety: keep() needs a process with one thread, and all of that process's signals and
// children.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "service/keeper/moments.h"

namespace sleight::keeper {

struct KeeperOptions {
  std::string folder{};
  std::uint32_t attempt = 1;
  std::vector<std::string> command{};
  bool with_ranks = false;  ///< the command runs mpirun
  bool in_batch = false;    ///< the keeper runs in a batch system's job
  double grace_s = 30;      ///< as in AttemptSpec
};

/// Grace time for an mpirun whose ranks have exited, unless the attempt's grace time is shorter.
inline constexpr double k_without_ranks_s = 10;
/// An mpirun that has started no rank within this time counts as hanging.
inline constexpr double k_first_rank_s = 60;

/// Returns `ok` after the attempt's end is recorded, however the program ended. Returns `conflict`,
/// with a message on stderr, if another keeper has the folder or the attempt has begun before.
/// Throws base::Error if the folder can't be written.
base::ExitCode keep(const KeeperOptions& options, Moments& moments);

}  // namespace sleight::keeper
