// Decides the state of a job whose attempt has ended. The decision depends only on the job, on what
// the daemon observed, and on people's requests.
//
//   Result of judge(job, ended):
//     If the request is finished, the job is done. If the request was extended meanwhile, the job
//       is queued.
//     If a search gave up but has finds or solutions, the job is done. If a search gave up without
//       finds and solutions, the job is failed.
//     If the run has no draws, or failed under --strict, the job is failed and never restarted.
//     If the request is invalid or the run store is damaged, the job is failed, because another
//       start would fail too.
//     If the disk is full or the results version differs, the job is held.
//     A failed check of the program counts as a death. If the previous failed check was at the same
//       place and nothing was committed since, the job is failed.
//     If the job was cancelled in the batch system, the job is held until the user resumes it.
//     If the batch system took the job's cores, the job starts again. This isn't a death.
//     After a clean stop, the job gets the requested outcome. If nobody requested the stop, the job
//       starts again.
//     Any other error, or a missing record, counts as a death. The job starts again later. After
//       the fifth death without a commit in between, the job is failed.
//
// If a stop was requested, a job that would start again gets the requested outcome instead. A
// cancelled job becomes cancelled unless its request is finished.
//
// Thread safety: pure functions.
#pragma once

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

/// Facts outside the job that affect the verdict.
struct Surroundings {
  bool is_disk_low = false;
  bool has_other_results = false;  ///< the run has another results version than the programs
};

/// REQUIRES: an attempt of the job is open; `job.counts` are the counts at the end.
Verdict judge(const Job& job, const Ended& ended, const Surroundings& around,
              const Options& options);
Verdict judge(const Job& job, const Died& died, const Options& options);
Verdict judge(const Job& job, const LaunchFailed& failed, const Surroundings& around,
              const Options& options);
/// Judges an attempt that never began although it was launched several times.
Verdict judge_unbegun(const Job& job, const Options& options);

/// Updates the job's deaths, back-offs and bugs from the verdict. Returns the delay before the next
/// start. `lived_s`: how long the attempt lived.
double count_end(Job& job, const Verdict& verdict, const std::string& place, double lived_s,
                 const Options& options);

/// Returns the state of a job after a stop requested for this reason: queued, held or cancelled.
State state_after_stop(Reason reason);

}  // namespace sleight::jobs
