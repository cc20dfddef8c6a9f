// Attempts on this machine. The daemon awaits each keeper's end (service/keeper/backend.h).
//
//   `Launch` writes request.toml and starts a keeper. The keeper's record leads to Launched.
//   `Look` reads the folder's record and reports a Sight. A running keeper's end is awaited.
//   `Stop` sends a signal to the keeper.
//   When a keeper exits, Sight {Ended or Died} follows. If there is no record, LaunchFailed
//     follows.
//   From time to time, running attempts lead to Sight {Running}.
//
// Thread safety: as Attempts.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "common/base/clock.h"
#include "common/base/file_system.h"
#include "common/rpc/loop.h"
#include "service/daemon/attempt_sights.h"
#include "service/daemon/attempts.h"
#include "service/daemon/feeds.h"
#include "service/daemon/job_folder.h"
#include "service/keeper/backend.h"

namespace sleight::daemon {

/// Delay before another look at a keeper that has no record or can't be awaited yet.
inline constexpr double k_again_s = 0.02;

class LocalAttempts final : public Attempts {
 public:
  struct Parts {
    rpc::Loop& loop;
    const base::Clock& clock;
    base::FileSystem& files;
    const JobFolders& folders;
    Feeds& feeds;
    const keeper::LocalBackend& backend;
    TextOf text_of;
    Hear hear;
  };
  explicit LocalAttempts(Parts parts);

  void launch(const jobs::Launch& launch) override;
  void stop(const jobs::Stop& stop) override;
  void look(const jobs::Look& look) override;
  std::optional<jobs::BackendNote> look_at_programs() override {
    return sights_.look_at_programs();
  }
  std::size_t running() const override { return running_.size(); }

 private:
  struct Run {
    jobs::Attempt attempt;
    std::optional<keeper::RunningKeeper> keeper;
    rpc::Loop::Handle gone;
    bool has_begun = false;  ///< it has a record
    WatchedRun watched{};
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

  Parts parts_;
  AttemptSights sights_;
  std::map<jobs::JobId, Run> running_;
  std::map<jobs::JobId, rpc::Loop::Handle> again_;
  rpc::Loop::Handle polling_{};
  double poll_every_s_ = 0;
};

}  // namespace sleight::daemon
