// The local backend: starts, signals and inspects attempts for a daemon that may be killed at any
// time.
//
// Each attempt runs under a keeper (`sleight-keeper`, keep.h). The keeper is a separate process
// that outlives the daemon. A new daemon needs only the job's folder and the attempt's number:
//
//   `backend.launch(spec)`: store the number first. Returns once the keeper runs.
//   `backend.look(folder, attempt)`: call at any time, from any daemon. The answers are:
//     `never_began`: launch the same attempt again. If two keepers start, only one of them starts
//       the program.
//       While the keeper that launch() returned is alive, `never_began` means "not yet".
//     `running`: call adopt(folder, attempt), wait for the keeper's descriptor, then look again. If
//       adopt() returns none, the keeper has just started or exited: look again some milliseconds
//       later.
//     `ended`: the record contains the attempt's end.
//     `died`: keeper and program were killed. Start a new attempt.
//
// Invariants:
//   1. A folder has at most one keeper, because the keeper holds a lock for life. An attempt's
//      program is started at most once.
//   2. `ended` and `died` are final: no process of the attempt runs any more. After a keeper's
//      death, the kernel may take up to 0.1 s to kill its program.
//   3. Signals reach only the attempt's own keeper, never a process with a reused process id.
//   4. A launched keeper doesn't share the daemon's descriptors, terminal or process group, and
//      leaves no zombie.
//   5. No function waits for a program. launch() waits for one exec.
//
// The lock uses fcntl's F_OFD_SETLK instead of flock. Either lock is released when the keeper ends.
// But only an F_OFD_SETLK lock can be tested without being taken. So look() never makes a starting
// keeper believe that another keeper exists.
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

/// A keeper that was running when this object was created. Move-only.
class RunningKeeper {
 public:
  /// `descriptor` is a pidfd.
  RunningKeeper(ProcessIdentity identity, base::Descriptor descriptor);

  const ProcessIdentity& identity() const { return identity_; }
  /// Descriptor for poll, readable once the keeper has exited.
  int descriptor() const { return descriptor_.get(); }
  bool has_gone() const;
  /// False: the keeper has exited. Repeated calls are allowed, also `now` after `in_order`.
  bool stop(Stop how) const;

 private:
  ProcessIdentity identity_;
  base::Descriptor descriptor_;
};

struct Look {
  enum class State : std::uint8_t { never_began, running, ended, died };
  State state = State::never_began;
  /// The attempt's record. Missing if the attempt never began or its keeper has just started.
  std::optional<AttemptRecord> record{};
  /// If the attempt never began: the keeper's error output, such as "disk full". Usually empty.
  std::string words{};
};

class LocalBackend {
 public:
  explicit LocalBackend(Programs programs);

  /// Starts a keeper. When launch() returns, the program doesn't run yet and may never run; look()
  /// reports whether it does. Throws base::Error if no keeper can be started, or if this machine
  /// can't run the spec (more ranks than cores, no mpirun).
  RunningKeeper launch(const AttemptSpec& spec) const;
  /// Works like launch(), but accepts a complete keeper command (keeper_command_of).
  RunningKeeper launch_command(const std::string& folder, std::vector<std::string> command) const;

  /// Throws base::Error if the record is unreadable, or if it belongs to a later attempt. Only
  /// another daemon can have started a later attempt.
  Look look(const std::string& folder, std::uint32_t attempt) const;

  /// Returns the keeper of a running attempt. None: the attempt isn't running, or it has no record
  /// yet. look() distinguishes these cases. Throws like look.
  std::optional<RunningKeeper> adopt(const std::string& folder, std::uint32_t attempt) const;

  /// Adopts the keeper and stops it. False: the attempt isn't running, or has no record yet.
  bool stop(const std::string& folder, std::uint32_t attempt, Stop how) const;

  const Programs& programs() const { return programs_; }

 private:
  Programs programs_;
};

}  // namespace sleight::keeper
