// The keeper starts a job's program and records how it ends. Each attempt has one keeper, which is
// a process.
//
//   1. Takes the folder's lock. Exits if the lock is taken, or if the folder's record is of this
//      attempt or a later attempt. So if an attempt is launched twice, the program runs once.
//   2. Removes the remains of a killed attempt. Creates the pipe on which the program will report
//      its session's end (common/events/run_end.h), then writes the attempt's record.
//   3. Starts the program (program.h) and waits. Meanwhile the keeper writes the program's output
//      to the bounded log, and handles signals:
//        `SIGUSR1`, `SIGINT`: send SIGUSR1 to the program, which stops a run cleanly.
//        `SIGTERM`: kill the program and all its descendants.
//        `SIGHUP`: ignore.
//      If the program reported its end but doesn't exit, the keeper kills it. If all ranks have
//      exited but mpirun doesn't, the keeper kills mpirun (Debian 12's mpirun sometimes hangs while
//      exiting).
//   4. After the program has ended, kills its remaining descendants. The keeper is their subreaper,
//      so it can wait for all of them.
//   5. Writes the record with the end. If the pipe reported no end, the keeper takes the end of
//      this attempt's session from the run store, if there is one.
//
// In a batch system's job (KeeperOptions::in_batch) five things differ:
//
//   1. The system sends SIGTERM to all processes some time before killing them. The keeper forwards
//      SIGTERM as SIGUSR1. The program itself blocks SIGTERM, so it doesn't receive two signals.
//   2. The program gets the whole environment, because mpirun finds the job's machines in it.
//   3. On a network disk, locks outlive a lost machine, so the file `begun.N` replaces the lock. If
//      the system starts an attempt twice, the attempt runs once.
//   4. If a second keeper starts on the same machine, it waits until the first keeper exits.
//      Otherwise the system would interpret the second keeper's exit as the end of the job.
//   5. If a keeper was presumed lost, it doesn't overwrite a later attempt's record.
//
// Invariants:
//   1. The keeper holds the lock while it lives. The keeper waits for all processes of the program,
//      so none outlives the keeper. If the keeper is killed, the kernel kills the program, and the
//      program's death ends its ranks (clients/cli/end_with_mpirun.h).
//   2. The record of the end is written after all processes of the program ended.
//
// Thread safety: keep() needs a process that has one thread. All signals and children of the
// process belong to keep().
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

/// Grace time for mpirun after its ranks have exited. If the attempt's grace time is shorter, that
/// applies.
inline constexpr double k_without_ranks_s = 10;
/// If mpirun has started no rank within this time, it counts as hanging.
inline constexpr double k_first_rank_s = 60;

/// Returns `ok` after it has recorded the attempt's end, however the program ended. If another
/// keeper has the folder, or the attempt has begun before, prints a message on stderr and returns
/// `conflict`. Throws base::Error if the folder can't be written.
base::ExitCode keep(const KeeperOptions& options, Moments& moments);

}  // namespace sleight::keeper
