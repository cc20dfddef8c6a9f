// Decides the state of a job whose attempt has ended. The decision depends only on the job, on the
// daemon's observations of the attempt, and on people's requests.
//
//   Result of judge(job, ended):
//     Request finished: done, or queued if the request was extended meanwhile.
//     Gave up, no draws, or failed under --strict: failed, and never restarted. Gave up with finds:
//       done.
//     Invalid request: failed, because another start would be refused too.
//     Disk full, other results version: held.
//     A check of the program failed: a death. If the previous failed check was at the same place,
//       with no commit since: failed.
//     Cancelled in the batch system: held until the user resumes the job.
//     The batch system took the job's cores: starts again, not a death.
//     Clean stop: the outcome for which the stop was requested. Without a request: starts again.
//     Any other error, or no record: a death. Starts again later; the fifth death without a
//       commit in between: failed.
//
// After a stop request, a job that would start again gets the outcome that the request named. A
// cancelled job becomes cancelled unless its request is finished.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "service/jobs/messages.h"
#include "service/jobs/options.h"

namespace sleight::jobs {

struct Verdict {
  State to = State::queued;
  Reason reason = Reason::died;
  std::string words{};
  bool backs_off = false;  ///< the next start is delayed, longer each time
  bool is_death = false;   ///< counts towards deaths_max
  bool is_bug = false;     ///< the place of the failed check is stored
};

/// The machine's view of the surroundings of a job.
struct Surroundings {
  bool is_disk_low = false;
  bool has_other_results = false;  ///< the run has another results version than the programs
};

/// REQUIRES: an attempt of the job is open; job.counts are those of the end.
Verdict judge(const Job& job, const Ended& ended, const Surroundings& around,
              const Options& options);
Verdict judge(const Job& job, const Died& died, const Options& options);
Verdict judge(const Job& job, const LaunchFailed& failed, const Surroundings& around,
              const Options& options);
/// Judges an attempt that never began, however often it was launched.
Verdict judge_unbegun(const Job& job, const Options& options);

/// Updates the job's deaths, back-offs and bugs from the verdict. Returns the delay before the next
/// start. `lived_s` is how long the attempt lived.
double count_end(Job& job, const Verdict& verdict, const std::string& place, double lived_s,
                 const Options& options);

/// Returns the state of a job after a stop requested for this reason: queued, held or cancelled.
State state_after_stop(Reason reason);

}  // namespace sleight::jobs
