// The local backend: starts, signals and looks at attempts on this machine, for a daemon that may
// be killed and started again at any moment.
//
// Each attempt is held by a keeper, a process of its own (`sleight-keeper`, keep.h) that no
// daemon's end touches. All that a daemon needs to go on with is the job's folder and the attempt's
// number:
//
//   backend.launch(spec)            before: the number is stored. It returns once the keeper runs
//   backend.look(folder, attempt)   at any time, by any daemon
//     never_began  launch the same attempt again: of two keepers one starts the program. As long as
//                  the keeper that launch returned has not gone, it means "not yet"
//     running      adopt(folder, attempt), wait for its descriptor, then look again. None to adopt:
//                  it has just begun, or gone: look again some milliseconds later
//     ended        the record has its end
//     died         the keeper was killed, and the program with it: a new attempt
//
// Invariants:
//   1. A folder has at most one keeper, by a lock that lives as long as it; an attempt's program is
//      started at most once.
//   2. `ended` and `died` are final: nothing of the attempt runs any more, but for the moment that
//      the kernel takes to kill a dead keeper's program, under 0.1 s.
//   3. Signals reach the keeper of the attempt that they are meant for, never another process that
//      has got its number.
//   4. launch starts nothing that holds a descriptor of the daemon's, its terminal or its process
//      group, and leaves no zombie.
//   5. No function waits for a program. launch waits for one exec.
//
// The lock is one of fcntl's on open file descriptions (F_OFD_SETLK) rather than flock's: like it,
// it goes with the keeper, but one can ask for it without taking it, so that a look never makes a
// keeper that just begins believe that there is another.
//
// Thread safety: any thread; functions are independent of one another.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/descriptor.h"
#include "service/keeper/attempt_record.h"
#include "service/keeper/command.h"

namespace sleight::keeper {

/// A keeper that runs, or did when this was made. Move-only.
class RunningKeeper {
 public:
  /// `descriptor` is a pidfd.
  RunningKeeper(ProcessIdentity identity, base::Descriptor descriptor);

  const ProcessIdentity& identity() const { return identity_; }
  /// For poll and its like: becomes readable when the keeper has gone, and stays so.
  int descriptor() const { return descriptor_.get(); }
  bool has_gone() const;
  /// False: it has gone. May be called again, in_order then now too.
  bool stop(Stop how) const;

 private:
  ProcessIdentity identity_;
  base::Descriptor descriptor_;
};

struct Look {
  enum class State : std::uint8_t { never_began, running, ended, died };
  State state = State::never_began;
  /// The attempt's. Always of ended and died; of running, unless the keeper has just begun.
  std::optional<AttemptRecord> record{};
  /// Of one that never began: what the keeper that was to start it said, such as that the disk is
  /// full. Empty mostly.
  std::string words{};
};

class LocalBackend {
 public:
  explicit LocalBackend(Programs programs);

  /// The program does not run yet when this returns, and may never: look says. Throws base::Error
  /// where no keeper can be started, or the spec can't be run here (more ranks than cores, no
  /// mpirun).
  RunningKeeper launch(const AttemptSpec& spec) const;
  /// The same with a keeper's command as it stands (keeper_command_of).
  RunningKeeper launch_command(const std::string& folder, std::vector<std::string> command) const;

  /// Throws base::Error where the record can't be read, or is of a later attempt: another daemon
  /// uses the folder.
  Look look(const std::string& folder, std::uint32_t attempt) const;

  /// The keeper of a running attempt. None where it is not running, or has no record yet: look
  /// tells the two apart. Throws as look.
  std::optional<RunningKeeper> adopt(const std::string& folder, std::uint32_t attempt) const;

  /// adopt, and stop. False: nothing to stop, or no record yet.
  bool stop(const std::string& folder, std::uint32_t attempt, Stop how) const;

  const Programs& programs() const { return programs_; }

 private:
  Programs programs_;
};

}  // namespace sleight::keeper
