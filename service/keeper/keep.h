// The keeper: one process for one attempt, which starts the job's program, hears how it ended, and
// writes it down.
//
//   1. Takes the folder's lock, or ends; ends too where the folder's record is of this attempt or a
//      later one. So an attempt that is launched twice runs once.
//   2. Clears what an attempt that was killed has left, makes the pipe through which the program
//   tells
//      how its session ended (common/events/run_end.h), and writes its record.
//   3. Starts the program (program.h) and waits. Meanwhile it puts what the program prints into the
//      bounded log, and takes signals:
//        SIGUSR1, SIGINT   passed on to the program as SIGUSR1, which ends a run in order
//        SIGTERM           the program and all its descendants are killed
//        SIGHUP            ignored
//      It kills a program that has told its end and lingers, and an mpirun whose ranks have all
//      gone (Debian 12's hangs in its own end then, now and then).
//   4. Once the program has ended, kills what is left of its descendants, which are all its own to
//      wait for, as it is their subreaper.
//   5. Writes the record with the end. Where the pipe told none, the run's store may: a session
//   newer
//      than those before.
//
// In a batch system's job (KeeperOptions::in_batch) it differs in five things. SIGTERM, which such
// a system sends to all processes some time before it kills them, is passed on as SIGUSR1, and kept
// from the program, which would be told twice. The program has the whole environment, in which
// mpirun finds the job's machines. On a network disk, whose locks outlive a lost machine, the file
// `begun.N` takes the lock's place: so an attempt that the system starts twice runs once. A second
// keeper on the first one's machine waits for its end, as the system would take its own end for
// that of all. And a keeper that was thought lost writes nothing over a later attempt's record.
//
// Invariants:
//   1. While the keeper lives the lock is held; once it has gone, nothing of the program is left:
//   it
//      waits for all of it, or, killed, the kernel kills the program, which takes its own ranks
//      along (clients/cli/end_with_mpirun.h).
//   2. The record of the end is written when nothing of the program runs any more.
//
// Thread safety: keep has the process for itself: its signals, its children, one thread.
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
  bool with_ranks = false;  ///< the command is mpirun's
  bool in_batch = false;    ///< a batch system's job holds the keeper
  double grace_s = 30;      ///< as in AttemptSpec
};

/// The grace of an mpirun without ranks, where that of the attempt is not shorter.
inline constexpr double k_without_ranks_s = 10;
/// By then an mpirun has started one, or hangs.
inline constexpr double k_first_rank_s = 60;

/// Returns when the attempt has ended and is recorded: `ok`, whatever its end. `conflict`: there is
/// nothing to do, since another keeper has the folder, or the attempt has begun before; said on
/// stderr. Throws base::Error where the folder can't be written.
base::ExitCode keep(const KeeperOptions& options, Moments& moments);

}  // namespace sleight::keeper
