// What it means for a job that an attempt came to an end: pure functions of the job, of what was
// seen, and of what was asked for.
//
//   judge(job, ended):
//     its request's end was reached      done, or queued if it was extended meanwhile
//     gave up, no draws, --strict        failed, and never restarted (gave up with finds: done)
//     the request is refused             failed: it would be refused again
//     no room on disk, other results     held
//     a check failed                     failed if it is the same place and nothing was committed
//                                        since; else a death
//     cancelled in the batch system      held: it goes on when its user says so
//     its place was taken away           starts again, and is no death
//     stopped in order                   what the stop was asked for; else it starts again
//     any other error, or no record      a death: starts again later; the fifth without a commit
//                                        between: failed
//   Where a stop was asked for, that is what becomes of a job that would start again; a cancelled
//   one is cancelled unless its request's end was reached.
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
  bool backs_off = false;  ///< the next start waits, longer each time
  bool is_death = false;   ///< counted: without a commit between, five are enough
  bool is_bug = false;     ///< whose place is noted
};

/// What the machine knows of the surroundings.
struct Surroundings {
  bool is_disk_low = false;
  bool has_other_results = false;  ///< the programs are of another results version than the run
};

/// REQUIRES: an attempt of the job is open; job.counts is what the end says.
Verdict judge(const Job& job, const Ended& ended, const Surroundings& around,
              const Options& options);
Verdict judge(const Job& job, const Died& died, const Options& options);
Verdict judge(const Job& job, const LaunchFailed& failed, const Surroundings& around,
              const Options& options);
/// No launch of the attempt ever began.
Verdict judge_unbegun(const Job& job, const Options& options);

/// Counts the verdict into the job's deaths, back-offs and bugs, and returns how long its next
/// start waits. `lived_s` is how long the attempt did.
double count_end(Job& job, const Verdict& verdict, const std::string& place, double lived_s,
                 const Options& options);

/// What a job becomes that was asked to stop for this reason: queued, held or cancelled.
State state_after_stop(Reason reason);

}  // namespace sleight::jobs
