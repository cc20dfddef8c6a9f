// Slurm as a backend, used through the commands sbatch, squeue and scancel.
//
//   `launch`   first searches the queue for an earlier submission with the comment NAME. If there
//              is none, it runs sbatch --parsable --no-requeue --comment=NAME ... direct.sbatch
//              --attempt COMMAND.
//   `list`     runs squeue for all of this user's jobs, at most every list_every_s.
//   `signal`   runs scancel. A running job gets scancel --signal=USR1 --batch, which signals its
//              keeper.
//   `log`      reads what Slurm and the keeper wrote into a file in the job's folder.
//
// No Slurm job number is stored: an attempt is found by its name, which is its Slurm job's comment.
// So a restarted daemon finds its attempts again, even if sbatch was killed before it printed the
// job number. If sbatch's answer is lost, there may be two Slurm jobs for one attempt. Only one of
// the two jobs starts the program, because the second keeper finds the attempt begun (keep.h).
//
// Slurm keeps ended jobs in its queue for MinJobAge (default 300 s). After that time, a job is
// absent, and its keeper's record shows how it ended. sacct isn't used, because many sites lack it.
//
// Not thread-safe.
#pragma once

#include <atomic>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "service/backend/backend.h"
#include "service/backend/slurm_queue.h"
#include "service/keeper/tool.h"

namespace sleight::backend {

struct SlurmSettings {
  std::string script{};  ///< path of deploy/slurm/direct.sbatch, absolute
  Options defaults{};    ///< defaults for jobs' options (slurm_options.h)
  double list_every_s = 10;
  double tool_s_max = 60;  ///< maximum for a Slurm command, which is then killed
  // Slurm's commands, as names on PATH or absolute paths.
  std::string sbatch = "sbatch";
  std::string squeue = "squeue";
  std::string scancel = "scancel";
};

/// Slurm and the keeper write into this file in the job's folder.
inline constexpr const char* k_slurm_log_name = "keeper.err";

class SlurmBackend final : public Backend {
 public:
  /// Borrows the clock. Throws base::Error(usage) if the defaults are invalid.
  SlurmBackend(SlurmSettings settings, const base::Clock& clock);

  Seen launch(const Order& order) override;
  Seen state(const AttemptName& name) override;
  bool signal(const AttemptName& name, keeper::Stop how) override;
  std::map<AttemptName, Seen> list(const std::string& daemon) override;
  bool are_lists_cheap() const override { return true; }
  std::string log(const AttemptName& name, const std::string& folder,
                  std::size_t bytes_max) override;
  void end_soon() override { is_ending_ = true; }
  std::string title() const override { return "Slurm"; }

 private:
  const SlurmQueue& queue(bool afresh);
  void ask(double now_s);
  std::vector<std::string> submission_of(const Order& order) const;
  void submit(const Order& order);
  Seen seen_in(const SlurmQueue& queue, const AttemptName& name) const;
  keeper::ToolEnd run(const std::vector<std::string>& command);

  SlurmSettings settings_;
  const base::Clock& clock_;
  std::vector<std::string> environment_;
  SlurmQueue queue_{};
  std::optional<double> asked_s_{};  ///< time of the query that filled queue_
  std::optional<double>
      away_s_{};  ///< time of the last unanswered query; none: the last was answered
  std::string away_words_{};
  std::set<AttemptName> unsure_{};     ///< launches whose answer was lost
  std::set<std::string> cancelled_{};  ///< Slurm job numbers that this object cancelled
  std::atomic<bool> is_ending_ = false;
};

}  // namespace sleight::backend
