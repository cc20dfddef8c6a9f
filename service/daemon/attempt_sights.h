// Reads jobs' folders and reports on attempts to the machine of jobs. A report tells a run's
// progress, its end, or what prevents it from continuing. Thread safety: only the loop's thread
// makes calls.
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

/// Memory that a job's process needs without its cache.
inline constexpr std::uint64_t k_process_bytes = std::uint64_t{256} << 20U;
/// Intervals at which a run is inspected: the first applies before the run's first commit, the
/// second later.
inline constexpr double k_look_young_s = 0.1;
inline constexpr double k_look_s = 1;
/// Interval at which a running job is reported to the machine.
inline constexpr double k_tell_running_s = 5;
/// Interval at which the size of a job's folder is measured.
inline constexpr double k_measure_s = 10;

/// What the last inspection of a running job showed.
struct WatchedRun {
  double since_s = 0;     ///< time of the launch, or when the run was found
  bool is_found = false;  ///< an earlier daemon launched it at an unknown time
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
  /// If an inspection is due, inspects the run. Returns a report if the machine needs one.
  std::optional<jobs::Running> news(jobs::JobId job, WatchedRun& run, double now_s);

  /// REQUIRES: the record has an end.
  jobs::Ended ended(jobs::JobId job, const keeper::AttemptRecord& record,
                    std::optional<double> first_commit_after_s);
  /// `record`: null if the attempt left no record.
  jobs::Died died(jobs::JobId job, const keeper::AttemptRecord* record, std::string words);
  jobs::LaunchFailed launch_failed(jobs::JobId job, jobs::Attempt attempt,
                                   const std::string& words) const;

  /// If the programs were replaced since the last call, returns a note for the machine. The first
  /// call always returns a note.
  std::optional<jobs::BackendNote> look_at_programs();

 private:
  jobs::Hindrance hindrance_of(jobs::JobId job, const keeper::AttemptEnd& end) const;
  bool has_no_room(const std::string& words) const;
  jobs::Counts counts_of(jobs::JobId job, bool thoroughly);
  std::string run_results_version(jobs::JobId job) const;

  Parts parts_;
  std::optional<std::string> programs_stamp_{};
  std::string results_version_{};  ///< of the installed programs
};

}  // namespace sleight::daemon
