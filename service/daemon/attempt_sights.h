// What a job's folder says of its attempts, as the machine of jobs is told it: how a run goes on,
// how it ended, what hinders it. It makes no difference which backend has the attempt.
//
// Thread safety: all on the loop's thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/clock.h"
#include "service/daemon/feeds.h"
#include "service/daemon/job_folder.h"
#include "service/jobs/messages.h"
#include "service/keeper/attempt_record.h"
#include "service/keeper/command.h"

namespace sleight::daemon {

/// What a process of a job takes up beside its cache.
inline constexpr std::uint64_t k_process_bytes = std::uint64_t{256} << 20U;
/// A run that has committed nothing yet is looked at so often, any other so often.
inline constexpr double k_look_young_s = 0.1;
inline constexpr double k_look_s = 1;
/// The machine is told of a run that goes on so often.
inline constexpr double k_tell_running_s = 5;
/// The size of its folder is measured so often.
inline constexpr double k_measure_s = 10;

/// A run that goes on, as it was seen last.
struct WatchedRun {
  double since_s = 0;     ///< launched, or found
  bool is_found = false;  ///< an earlier daemon's: when it was launched isn't known
  double told_s = 0;
  std::uint64_t told_scans = 0;
  std::uint64_t scans_before = 0;
  std::optional<double> first_commit_after_s{};
  double looked_s = 0;
  double measured_s = 0;
  std::uint64_t disk_bytes = 0;
  std::string results_version{};

  bool is_young() const { return !is_found && !first_commit_after_s; }
};

class AttemptSights {
 public:
  struct Parts {
    const base::Clock& clock;
    const JobFolders& folders;
    Feeds& feeds;
    keeper::Programs programs{};
  };
  explicit AttemptSights(Parts parts);

  WatchedRun watch(jobs::JobId job, bool is_found);
  jobs::Running running(jobs::JobId job, WatchedRun& run);
  /// The same where the machine is to hear of it, and it is time to look.
  std::optional<jobs::Running> news(jobs::JobId job, WatchedRun& run, double now_s);

  /// REQUIRES: the record has an end.
  jobs::Ended ended(jobs::JobId job, const keeper::AttemptRecord& record,
                    std::optional<double> first_commit_after_s);
  /// `record`: null where it left none.
  jobs::Died died(jobs::JobId job, const keeper::AttemptRecord* record, std::string words);
  jobs::LaunchFailed launch_failed(jobs::JobId job, jobs::Attempt attempt,
                                   const std::string& words) const;

  /// Of programs that were replaced since the last look, the first one included: what the machine
  /// is to hear of them.
  std::optional<jobs::BackendNote> look_at_programs();

 private:
  jobs::Hindrance hindrance_of(jobs::JobId job, const keeper::AttemptEnd& end) const;
  bool has_no_room(const std::string& words) const;
  jobs::Counts counts_of(jobs::JobId job, bool thoroughly);
  std::string run_results_version(jobs::JobId job) const;

  Parts parts_;
  std::optional<std::string> programs_stamp_{};
  std::string results_version_{};  ///< of the programs on the disk
};

}  // namespace sleight::daemon
