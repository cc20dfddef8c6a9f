// Runs the jobs: joins the machine of jobs (service/jobs) with its store, backend and clock.
//
// Data flow:
//   calls, sights, time ──▶ machine ──▶ Save ──▶ store (a thread) ──▶ board, answers, attempts
//
// Invariants
//   1. Each decision of the machine is durable before anybody sees it. Each decision is also
//      durable before a program is started or stopped because of it. All effects are carried out in
//      the order of their steps.
//   2. A request's text is saved together with its job or its revision.
//
// Thread safety: only the loop's thread makes calls.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/file_system.h"
#include "common/rpc/loop.h"
#include "service/backend/backend.h"
#include "service/daemon/attempts.h"
#include "service/daemon/board.h"
#include "service/daemon/feeds.h"
#include "service/daemon/job_folder.h"
#include "service/daemon/job_store.h"
#include "service/daemon/save_queue.h"
#include "service/daemon/worker.h"
#include "service/jobs/jobs.h"
#include "service/keeper/backend.h"

namespace sleight::daemon {

/// Seconds since 1970.
double wall_s();

struct RunnerOptions {
  std::string state{};  ///< existing state folder, an absolute path
  jobs::Options jobs{};
  std::uint32_t cores = 1;
  std::uint64_t memory_bytes = 0;
  std::uint64_t disk_reserve_bytes = 0;
  keeper::Programs programs{};
  /// The batch system that runs attempts. Null: this machine.
  std::shared_ptr<backend::Backend> system{};
  std::string
      daemon_id{};  ///< the state folder's name in the batch system (backend::is_daemon_name)
};

/// While jobs run or wait, free disk space and folder sizes are measured at this interval.
inline constexpr double k_room_every_s = 2;

class JobRunner {
 public:
  using Answered = std::function<void(const jobs::Answer&)>;
  /// Called for each job that has a durable change or events.
  using News = std::function<void(jobs::JobId)>;

  /// Opens the job store, with the folder's lock. Throws base::Error as JobStore does.
  JobRunner(rpc::Loop& loop, RunnerOptions options, News news,
            const store::RunLock* lock = nullptr);
  ~JobRunner();

  /// Takes over the jobs of earlier daemons.
  void begin();

  /// A new job with its request.
  struct Submission {
    jobs::Submit submit{};
    StoredRequest request{};
  };
  /// Submits all jobs. If one job is refused, submits none. `answered` receives all answers in
  /// order, once the changes are durable.
  void submit(std::vector<Submission> submissions,
              std::function<void(const std::vector<jobs::Answer>&)> answered);
  /// `request`: if jobs are extended, the new revision's request.
  void ask(jobs::Ask ask, Answered answered, std::optional<StoredRequest> request = {});
  void drain(bool on);

  const Board& board() const { return board_; }
  const jobs::Jobs& machine() const { return *machine_; }
  JobReader& reader() { return reader_; }
  Feeds& feeds() { return feeds_; }
  const JobFolders& folders() const { return folders_; }
  const RunnerOptions& options() const { return options_; }
  Worker& worker() { return worker_; }
  Worker& maker() { return maker_; }
  /// Id of the group that the next submission creates.
  jobs::GroupId next_group() const { return jobs::GroupId{next_id_}; }
  /// Why saving currently fails. Empty: saving works.
  const std::string& stalled() const { return stalled_; }
  /// From now on, delivers the job's events sooner.
  void watch(jobs::JobId job);

 private:
  std::unique_ptr<Attempts> make_attempts();
  void hear(jobs::Input input);
  std::vector<jobs::Effect> step(const jobs::Input& input);
  void carry_out(std::vector<jobs::Effect> effects, std::vector<StoredRequest> requests = {});
  void durable(const std::optional<Save>& save, const std::vector<jobs::Effect>& effects);
  void perform(const jobs::Effect& effect);
  void answer(const jobs::Answer& answer);
  void remove(jobs::JobId job);
  void plan_tick();
  void look_at_room();
  void look_at_watched();

  rpc::Loop& loop_;
  RunnerOptions options_;
  News news_;
  base::SteadyClock clock_;
  base::PosixFileSystem files_;
  JobFolders folders_;
  Feeds feeds_;
  keeper::LocalBackend backend_;
  Board board_;
  std::uint64_t next_id_ = 1;
  std::string stalled_{};
  std::unique_ptr<jobs::Jobs> machine_;
  std::shared_ptr<store::SharedDatabase> to_read_;
  std::unique_ptr<SaveQueue> saves_;
  JobReader reader_;
  std::unique_ptr<Attempts> attempts_;
  Worker worker_;
  Worker maker_;
  std::map<jobs::Token, Answered> owed_;
  jobs::Token next_token_ = 1;
  std::size_t pending_ = 0;  ///< steps whose effects wait for the store
  rpc::Loop::Handle ticking_{};
  rpc::Loop::Handle rooming_{};
  rpc::Loop::Handle watching_{};
  bool is_watching_ = false;
  double next_tick_s_ = -1;
};

}  // namespace sleight::daemon
