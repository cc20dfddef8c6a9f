// Carries out what the machine of jobs says of attempts, and tells it what is seen of them: the
// daemon's side of the local backend.
//
//   Launch      ──▶ request.toml and a keeper; once that has its record: Launched
//   Look        ──▶ the folder's record: Sight; a keeper that is found running is waited for
//   Stop        ──▶ a signal to the keeper
//   keeper gone ──▶ Sight {Ended or Died}; without a record: LaunchFailed
//   now and then──▶ Sight {Running}
//
// Thread safety: all on the loop's thread. What is heard is told through `hear`, never from inside
// launch, stop or look.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/file_system.h"
#include "common/rpc/loop.h"
#include "service/daemon/feeds.h"
#include "service/daemon/job_folder.h"
#include "service/jobs/messages.h"
#include "service/keeper/backend.h"

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
/// A keeper without a record, or one that can't be waited for yet, is looked at again so much
/// later.
inline constexpr double k_again_s = 0.02;

/// What a launch needs of the job beside its number.
struct LaunchText {
  std::string request{};
  bool strict = false;
};

class Attempts {
 public:
  using Hear = std::function<void(jobs::Input)>;
  using TextOf = std::function<LaunchText(jobs::JobId, std::uint64_t revision)>;

  struct Parts {
    rpc::Loop& loop;
    const base::Clock& clock;
    base::FileSystem& files;
    const JobFolders& folders;
    Feeds& feeds;
    const keeper::LocalBackend& backend;
    std::string results_version{};  ///< of the daemon's own programs; empty: not known
    TextOf text_of;
    Hear hear;
  };
  explicit Attempts(Parts parts);

  void launch(const jobs::Launch& launch);
  void stop(const jobs::Stop& stop);
  void look(const jobs::Look& look);

  /// Of programs that were replaced since the last look, the first one included: what the machine
  /// is to hear of them.
  std::optional<jobs::BackendNote> look_at_programs();

  /// Attempts whose keepers are waited for.
  std::size_t running() const { return running_.size(); }

 private:
  struct Run {
    jobs::Attempt attempt;
    std::optional<keeper::RunningKeeper> keeper;
    rpc::Loop::Handle gone;
    double since_s = 0;      ///< launched, or found
    bool is_found = false;   ///< an earlier daemon's: when it was launched isn't known
    bool has_begun = false;  ///< it has a record
    double told_s = 0;
    std::uint64_t told_scans = 0;
    std::uint64_t scans_before = 0;
    std::optional<double> first_commit_after_s{};
    double looked_s = 0;
    double measured_s = 0;
    std::uint64_t disk_bytes = 0;
    std::string results_version{};
  };

  void tell(jobs::Input input);
  void tell_launch_failed(jobs::JobId job, jobs::Attempt attempt, const std::string& words);
  void await_begin(jobs::JobId job, jobs::Attempt attempt);
  bool look_whether_begun(jobs::JobId job, jobs::Attempt attempt);
  bool tell_unbegun(jobs::JobId job, jobs::Attempt attempt);
  void follow(jobs::JobId job, jobs::Attempt attempt, keeper::RunningKeeper keeper, bool is_found);
  void keeper_gone(jobs::JobId job);
  void see(jobs::JobId job, jobs::Attempt attempt);
  void poll();
  void end_those_without_folder(double now_s);
  void plan_poll();
  std::optional<jobs::Running> running_of(jobs::JobId job, Run& run);
  jobs::Ended ended_of(jobs::JobId job, const keeper::AttemptRecord& record,
                       std::optional<double> first_commit_after_s);
  jobs::Died died_of(jobs::JobId job, const keeper::AttemptRecord& record);
  jobs::Hindrance hindrance_of(jobs::JobId job, const keeper::AttemptEnd& end) const;
  bool has_no_room(const std::string& words) const;
  jobs::Counts counts_of(jobs::JobId job, bool thoroughly);
  std::string run_results_version(jobs::JobId job) const;

  Parts parts_;
  std::map<jobs::JobId, Run> running_;
  std::map<jobs::JobId, rpc::Loop::Handle> again_;
  rpc::Loop::Handle polling_{};
  double poll_every_s_ = 0;
  std::optional<std::string> programs_stamp_{};
  std::string results_version_{};  ///< of the programs on the disk
};

}  // namespace sleight::daemon
