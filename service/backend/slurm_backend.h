// Slurm as a backend: by its programs sbatch, squeue and scancel alone, as a user has them.
//
//   launch   sbatch --parsable --no-requeue --comment=NAME ... direct.sbatch --attempt COMMAND
//            once the queue has been looked through for that comment
//   list     squeue of this user's jobs, at most every list_every_s, for all attempts together
//   signal   scancel, or scancel --signal=USR1 --batch of one that runs, which reaches its keeper
//   log      what Slurm and the keeper said, in the job's folder
//
// A number is never kept: an attempt is found by its name, which is its Slurm job's comment. So a
// daemon that was killed finds its attempts again, and so does one whose sbatch was killed before
// it answered. Two Slurm jobs of one attempt, which a lost answer can make, start one program: the
// second keeper finds that the attempt has begun (keep.h).
//
// Jobs that ended are in Slurm's queue for its MinJobAge (300 s if a site sets none); then they are
// absent, and the keeper's record says what became of them. sacct is not asked: many sites have
// none.
//
// Not thread-safe.
#pragma once

#include <atomic>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "service/backend/backend.h"
#include "service/backend/slurm_queue.h"
#include "service/keeper/tool.h"

namespace sleight::backend {

struct SlurmSettings {
  std::string script{};  ///< deploy/slurm/direct.sbatch, an absolute path
  Options defaults{};    ///< of jobs' options (slurm_options.h)
  double list_every_s = 10;
  double tool_s_max = 60;  ///< then a program of Slurm's is killed
  // As found on PATH, or absolute.
  std::string sbatch = "sbatch";
  std::string squeue = "squeue";
  std::string scancel = "scancel";
};

/// In the job's folder: what Slurm and the keeper print.
inline constexpr const char* k_slurm_log_name = "keeper.err";

class SlurmBackend final : public Backend {
 public:
  /// Borrows the clock. Throws base::Error(usage) where the defaults are wrong.
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
  std::optional<double> asked_s_{};  ///< when the queue was asked for that is here
  std::optional<double> away_s_{};   ///< when it did not answer; none: it answered last
  std::string away_words_{};
  std::set<AttemptName> unsure_{};     ///< launches whose answer was lost
  std::set<std::string> cancelled_{};  ///< numbers that this object cancelled
  std::atomic<bool> is_ending_ = false;
};

}  // namespace sleight::backend
