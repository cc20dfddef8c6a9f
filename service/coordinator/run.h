// One run from request to archive on this machine: take the output, go on where an earlier session
// stopped, drive the plan, derive the archive.
//
// Files of a run with output `ball.h5`: the archive `ball.h5` (derived, replaced whole) and the
// folder `ball.h5.run` with the run store (the truth) and what simulations failed
// (failure_files.h). The archive can be deleted and made again; deleting the folder gives up what
// isn't in the archive and the means to go on.
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

/// What a program's main brings together. Everything is borrowed for the call.
struct RunInputs {
  const request::DirectionRequest& request;
  const archive::StateReader& reader;
  plan::Plan& plan;  ///< fresh
  /// A fresh plan of the same run that ends at a cut: what a method learns from the scans of an
  /// archive is learnt again from these.
  std::function<std::unique_ptr<plan::Plan>(const request::Cut& cut)> plan_of;
  Crew& crew;
  const base::Clock& clock;
  /// Through which the output is taken and the archive written; the run store has SQLite's own.
  base::FileSystem& files;
  /// Of the program; a run goes on only under the one that it began with.
  std::string results_version;
};

struct RunOptions {
  std::string output;       ///< path of the archive
  bool fresh = false;       ///< give up an earlier run of this output
  double time_limit_s = 0;  ///< 0 for none
  std::function<bool()> stop_requested{};
  /// Hears of all that happens (run_events.h), in the calling thread; may be empty. The same is in
  /// the run's folder, for others (common/store/told_events.h).
  std::function<void(const events::RunEvent&)> hear{};
  /// An archive of the run so far, for people who watch (checkpoints.h); 0: none.
  double checkpoint_every_s = 60;
  bool strict = false;  ///< a simulation that fails ends the run
  /// Hears how the session ended, once, when the store has it or can't take it; may be empty. Not
  /// called where the session is refused before it has the store.
  std::function<void(const events::RunEnd&)> ended{};
};

struct RunSummary {
  DriveEnd end = DriveEnd::finished;
  std::uint64_t scans = 0;           ///< of every chain
  std::uint64_t found = 0;           ///< by a search
  std::uint64_t relaxed = 0;         ///< of these, takes
  std::string digest{};              ///< of the archive's content; empty: none could be written
  bool is_archive_given_up = false;  ///< it was told to stop while it wrote it
  std::uint64_t epoch = 0;           ///< 1 for a run's first session
  std::string first_failure{};       ///< of this session: its file, if it was kept
  events::Progress progress{};
  Handling handling{};
};

/// Throws base::Error: conflict where the output belongs to another request, to another results
/// version, to a running process or to nobody known; environment where the disk fails.
RunSummary run_request(const RunInputs& inputs, const RunOptions& options);

/// With which a program ends that ends so.
base::ExitCode exit_code_of(DriveEnd end);

/// The folder of an output's run store.
std::string run_folder(const std::string& output);

}  // namespace sleight::coordinator
