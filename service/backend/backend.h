// Interface to batch systems, which run attempts of jobs. Batch systems are Slurm, and any other
// system for which a program exists (program_backend.h). The interface is small, so a new backend
// takes little work. The conformance suite (tests/programs/backend_conformance.py) tests backends.
// The daemon needs no backend for attempts on this machine (daemon/local_attempts.h).
//
//   `launch(order)`   submits the attempt, unless the system has or had it already.
//   `state(name)`     returns waiting, running, gone, or absent (never there, or forgotten).
//   `list()`          returns the states of one daemon's attempts, by one query.
//   `signal(name)`    sends SIGUSR1 to the keeper, ends a waiting attempt, or ends any attempt now.
//   `log(name)`       returns the system's messages, such as why the attempt never began.
//
// A backend reports whether the system still has an attempt. The keeper's record in the job's
// folder (service/keeper/attempt_record.h) shows how the attempt ended.
//
// Invariants
//   1. (daemon, job, epoch) names an attempt. An attempt may be launched again by this process or a
//      later one, but its command takes effect only once. To this end, launch() first searches the
//      system for the name. If the system's answer was lost, the command may start twice and must
//      detect this, as a keeper does (keep.h).
//   2. `gone` is final: no process of the attempt runs any more. An `absent` attempt may have run
//      or not.
//   3. If the system doesn't answer, functions throw `Away`. The attempts may still run.
//   4. Daemons that use the same system don't see each other's attempts.
//
// Calls block for a bounded time. Thread safety: one thread at a time.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "service/keeper/attempt_record.h"

namespace sleight::backend {

/// The text form "sleight:DAEMON:JOB:EPOCH" identifies the attempt in the system.
struct AttemptName {
  std::string daemon{};     ///< a state folder's random name: 8 to 32 characters, a to z and 0 to 9
  std::uint64_t job = 0;    ///< from 1
  std::uint64_t epoch = 0;  ///< the attempt, from 1

  auto operator<=>(const AttemptName&) const = default;
};

bool is_daemon_name(std::string_view text);
/// REQUIRES: is_daemon_name(name.daemon), job and epoch from 1.
std::string to_text(const AttemptName& name);
/// Returns none if to_text() can't have written the text.
std::optional<AttemptName> attempt_name_of(std::string_view text);

/// Further options by key; each system has its own ("account", "partition", ...).
using Options = std::map<std::string, std::string>;

struct Order {
  AttemptName name{};
  std::string folder{};  ///< working folder: absolute, on a disk that the system's machines share
  std::vector<std::string> command{};  ///< the keeper's command; the program is an absolute path
  std::string label{};                 ///< shown in the system's queue
  std::uint32_t cores = 1;             ///< of one process; ignored with ranks
  std::uint32_t ranks = 0;             ///< one core each; 0: without MPI
  std::uint64_t memory_bytes = 0;      ///< of all processes together; 0: unspecified
  Options options{};

  bool operator==(const Order&) const = default;
};

enum class State : std::uint8_t {
  absent,
  waiting,  ///< in the system's queue
  running,
  gone,
  unknown  ///< the system has the attempt in another state
};
std::string_view name_of(State state);
std::optional<State> state_of(std::string_view name);

/// Cause of an attempt's end, as far as the system reports it.
enum class Cause : std::uint8_t {
  itself,     ///< ended, exceeded a limit, or couldn't begin
  taken,      ///< taken away by the system: pre-emption, a lost node
  cancelled,  ///< cancelled in the system, not through this backend
};
std::string_view name_of(Cause cause);
std::optional<Cause> cause_of(std::string_view name);

struct Seen {
  State state = State::absent;
  std::string id{};             ///< the system's own id; empty: none
  std::string words{};          ///< why the attempt waits, or how it ended: "Priority", "TIMEOUT"
  Cause cause = Cause::itself;  ///< for gone

  bool operator==(const Seen&) const = default;
};

/// Thrown if the system doesn't answer. The attempt's state is unknown.
class Away : public base::Error {
 public:
  /// `may_have_begun`: the launch may have reached the system.
  explicit Away(const std::string& message, bool may_have_begun = false)
      : base::Error(message), may_have_begun_(may_have_begun) {}
  bool may_have_begun() const { return may_have_begun_; }

 private:
  bool may_have_begun_;
};

/// Functions throw Away if the system doesn't answer, and base::Error if it refuses.
class Backend {
 public:
  virtual ~Backend() = default;

  /// Submits the attempt unless it was launched before. Returns its state.
  virtual Seen launch(const Order& order) = 0;
  virtual Seen state(const AttemptName& name) = 0;
  /// Returns false if there is nothing to signal. REQUIRES: a repeated `in_order` signal is
  /// harmless.
  virtual bool signal(const AttemptName& name, keeper::Stop how) = 0;
  /// Returns the daemon's attempts, as far as the system has or remembers them.
  virtual std::map<AttemptName, Seen> list(const std::string& daemon) = 0;
  /// Returns whether list() answers from a cache and queries the system only at intervals.
  virtual bool are_lists_cheap() const { return false; }
  /// Returns the last `bytes_max` bytes of the attempt's log. Empty: no log. `folder`: the folder
  /// in the attempt's order.
  virtual std::string log(const AttemptName& name, const std::string& folder,
                          std::size_t bytes_max) = 0;
  /// Makes a pending query throw Away soon, so that the daemon can stop. Callable from any thread.
  virtual void end_soon() {}
  /// The system's name for people, such as "Slurm".
  virtual std::string title() const = 0;
};

/// Throws base::Error(usage) if no backend can carry out the order. The reasons are an invalid
/// name, a relative folder, an empty command or control characters.
void check_order(const Order& order);

/// Returns the last bytes of a file. If possible, the text begins with a whole line. Empty: no such
/// file.
std::string end_of_file(const std::string& path, std::size_t bytes_max);

}  // namespace sleight::backend
