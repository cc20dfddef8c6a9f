// Batch systems that run attempts of jobs: Slurm, or any other through a program
// (program_backend.h). The interface is small, so that an engine is soon written; the conformance
// suite (tests/programs/backend_conformance.py) says whether one is right. The daemon needs none
// for this machine (daemon/local_attempts.h).
//
//   launch(order)   the system has the attempt, or had it once: nothing new begins then
//   state(name)     waiting, running, gone, or absent: the system has never had it, or forgot it
//   list()          the same of all attempts of one daemon, by one question to the system
//   signal(name)    in order: the keeper is told (SIGUSR1). Now, or while it waits: it is ended
//   log(name)       what the system has to say of it, such as why it never began
//
// A backend says whether the system still has an attempt. How the attempt ended is judged
// elsewhere, by its keeper's record in the job's folder (service/keeper/attempt_record.h).
//
// Invariants
//   1. An attempt is named by (daemon, job, epoch). However often it is launched, by this process
//      or a later one, its command is carried out once: a look for the name sees to it mostly, and
//      the command itself where an answer was lost (a keeper does: keep.h).
//   2. `gone` is final: nothing of the attempt runs any more. `absent` says nothing of the past.
//   3. A system that doesn't answer is `Away`, never an end.
//   4. Daemons that use the same system don't see each other's attempts.
//
// Calls block, each for a bounded time. Thread safety: one thread at a time.
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

/// "sleight:DAEMON:JOB:EPOCH" as text, by which a system is asked for it.
struct AttemptName {
  std::string daemon{};     ///< a state folder's random name: 8 to 32 of a to z and 0 to 9
  std::uint64_t job = 0;    ///< from 1
  std::uint64_t epoch = 0;  ///< the attempt, from 1

  auto operator<=>(const AttemptName&) const = default;
};

bool is_daemon_name(std::string_view text);
/// REQUIRES: is_daemon_name(name.daemon), job and epoch from 1.
std::string to_text(const AttemptName& name);
/// None for anything that to_text does not write.
std::optional<AttemptName> attempt_name_of(std::string_view text);

/// Further wishes, by their keys; each system has its own ("account", "partition", ...).
using Options = std::map<std::string, std::string>;

struct Order {
  AttemptName name{};
  std::string folder{};  ///< absolute, on a disk that the system's machines see; the working folder
  std::vector<std::string> command{};  ///< the keeper's, an absolute path first
  std::string label{};                 ///< for people who look at the system's queue
  std::uint32_t cores = 1;             ///< of one process; of no meaning with ranks
  std::uint32_t ranks = 0;             ///< of a core each; 0: no MPI
  std::uint64_t memory_bytes = 0;      ///< of all processes together; 0: not said
  Options options{};

  bool operator==(const Order&) const = default;
};

enum class State : std::uint8_t {
  absent,
  waiting,  ///< in the system's queue
  running,
  gone,
  unknown  ///< the system has it, and its state is none of these
};
std::string_view name_of(State state);
std::optional<State> state_of(std::string_view name);

/// Why an attempt is gone, as far as the system knows.
enum class Cause : std::uint8_t {
  itself,     ///< it ended, was too long or too large, or couldn't begin
  taken,      ///< the system took it away: pre-emption, a lost node
  cancelled,  ///< somebody cancelled it in the system, not through this backend
};
std::string_view name_of(Cause cause);
std::optional<Cause> cause_of(std::string_view name);

struct Seen {
  State state = State::absent;
  std::string id{};             ///< the system's own; empty: it has none
  std::string words{};          ///< why it waits, or how it went: "Priority", "TIMEOUT"
  Cause cause = Cause::itself;  ///< of gone

  bool operator==(const Seen&) const = default;
};

/// The system doesn't answer: nothing is known, and nothing is wrong with the attempt.
class Away : public base::Error {
 public:
  /// `may_have_begun`: of a launch that may have reached the system all the same.
  explicit Away(const std::string& message, bool may_have_begun = false)
      : base::Error(message), may_have_begun_(may_have_begun) {}
  bool may_have_begun() const { return may_have_begun_; }

 private:
  bool may_have_begun_;
};

/// Functions throw Away, and base::Error where the system refuses.
class Backend {
 public:
  virtual ~Backend() = default;

  /// Returns the attempt as it is then: one that was launched before is left alone.
  virtual Seen launch(const Order& order) = 0;
  virtual Seen state(const AttemptName& name) = 0;
  /// False: there is nothing to signal. REQUIRES of a signal in order that it can be sent again.
  virtual bool signal(const AttemptName& name, keeper::Stop how) = 0;
  /// All of one daemon that the system has or remembers.
  virtual std::map<AttemptName, Seen> list(const std::string& daemon) = 0;
  /// Whether list asks the system now and then only, and else answers from what it has.
  virtual bool are_lists_cheap() const { return false; }
  /// The end of it; empty where there is nothing. `folder` is its order's.
  virtual std::string log(const AttemptName& name, const std::string& folder,
                          std::size_t bytes_max) = 0;
  /// From any thread: what waits for the system ends soon, with Away. For a daemon that ends.
  virtual void end_soon() {}
  /// For people: "Slurm".
  virtual std::string title() const = 0;
};

/// Throws base::Error(usage) where no backend could carry the order out: a name that is none, a
/// folder that isn't absolute, an empty command, control characters.
void check_order(const Order& order);

/// The last bytes of a file, from a line's beginning where there is one; empty: no such file.
std::string end_of_file(const std::string& path, std::size_t bytes_max);

}  // namespace sleight::backend
