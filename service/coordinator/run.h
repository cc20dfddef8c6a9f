// Carries out one run, from request to archive, on this machine: reserves the output, resumes an
// earlier session's run, drives the plan and derives the archive.
//
// A run with output `ball.h5` has two parts: the archive `ball.h5` and the folder `ball.h5.run`.
// The folder has the run store and the failed simulations (failure_files.h). The archive is derived
// from the run store and replaced atomically. If the archive is deleted, it can be derived again.
// If the folder is deleted, the run can't be resumed, and only the archive remains.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/archive/world_layout.h"
#include "common/base/clock.h"
#include "common/base/file_system.h"
#include "common/events/progress.h"
#include "common/events/run_end.h"
#include "common/events/run_event.h"
#include "common/plan/plan.h"
#include "common/request/direction_request.h"
#include "service/coordinator/crew.h"
#include "service/coordinator/drive.h"

namespace sleight::coordinator {

/// Objects that a program's main function lends for the call.
struct RunInputs {
  const request::DirectionRequest& request;
  const archive::StateReader& reader;
  plan::Plan& plan;  ///< fresh
  /// Returns a fresh plan that ends at a cut. The plan learns again from an archive's scans.
  std::function<std::unique_ptr<plan::Plan>(const request::Cut& cut)> plan_of;
  Crew& crew;
  const base::Clock& clock;
  /// Gives access to the output's files. SQLite itself accesses the run store's files.
  base::FileSystem& files;
  /// The program's results version. A run can be resumed only by the version that began it.
  std::string results_version;
};

struct RunOptions {
  std::string output;       ///< path of the archive
  bool fresh = false;       ///< delete an earlier run of this output
  double time_limit_s = 0;  ///< 0: no limit
  std::function<bool()> stop_requested{};
  /// Receives all events (run_events.h) in the calling thread. May be empty. Other processes find
  /// the same events in the run's folder (common/store/told_events.h).
  std::function<void(const events::RunEvent&)> hear{};
  /// Interval of run checkpoints (checkpoints.h). 0: none.
  double checkpoint_every_s = 60;
  bool strict = false;  ///< a failed simulation ends the run
  /// Receives the session's end once, after the end was stored or storing failed. May be empty. Not
  /// called if the session was refused before the store was opened.
  std::function<void(const events::RunEnd&)> ended{};
};

struct RunSummary {
  DriveEnd end = DriveEnd::finished;
  std::uint64_t scans = 0;           ///< per chain
  std::uint64_t found = 0;           ///< by a search
  std::uint64_t relaxed = 0;         ///< takes among the finds
  std::string digest{};              ///< of the archive's content; empty: no archive was written
  bool is_archive_given_up = false;  ///< a stop was requested while the archive was written
  std::uint64_t epoch = 0;           ///< 1 for a run's first session
  std::string first_failure{};       ///< file of this session's first failure, if one was stored
  events::Progress progress{};
  Handling handling{};
};

/// Throws base::Error(conflict) if the output belongs to another request, another results version,
/// a running process or an unknown owner. Throws base::Error(environment) if the disk fails.
RunSummary run_request(const RunInputs& inputs, const RunOptions& options);

/// Returns the exit code for a run that ended in this way.
base::ExitCode exit_code_of(DriveEnd end);

std::string run_folder(const std::string& output);

}  // namespace sleight::coordinator
