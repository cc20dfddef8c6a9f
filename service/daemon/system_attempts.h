// Attempts in a batch system (service/backend). A thread queries the system. Keepers on other
// machines write into the jobs' folders, which are polled.
//
//   `Launch` writes request.toml and calls backend.launch. The launch leads to Sight {Pending} or
//     LaunchFailed.
//   `Look` awaits the next list of all attempts, reads the folder's record and reports a Sight.
//   `Stop` calls backend.signal.
//   Each second, the folders' records are read. They lead to Launched or Sight {Running or Ended}.
//   From time to time, all attempts are listed. The list leads to Sight {Pending} or to a result
//     below.
//
//     In the system     | the folder's record | result
//     waiting, running  | none                | Pending, with the system's words
//     running           | without an end      | Running
//     any               | with an end         | Ended; if stopped by somebody else, once the system
//                       |                     | reports by whom
//     gone, absent      | without an end      | Died, once no lease of its run can be alive
//     gone              | none                | Died, with the system's and the keeper's output
//     absent            | none                | NeverBegan, as an answer to a Look
//     doesn't answer    | none, without end   | Unknown, as an answer to a Look; never an end.
//
// Shared disks show new files late. So if an attempt is gone, its record is read for another
// k_settle_s.
//
// Thread safety: as Attempts.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/base/clock.h"
#include "common/base/file_system.h"
#include "common/rpc/loop.h"
#include "service/backend/backend.h"
#include "service/daemon/attempt_sights.h"
#include "service/daemon/attempts.h"
#include "service/daemon/feeds.h"
#include "service/daemon/job_folder.h"
#include "service/daemon/worker.h"
#include "service/keeper/command.h"

namespace sleight::daemon {

/// Watches a run lease (common/store/lease.h), to show whether a process on another machine can
/// still write the run. The watch takes no lease, so it blocks no other process.
class LeaseWatch {
 public:
  /// `run_folder`: the run store's folder, which may be missing.
  explicit LeaseWatch(std::string run_folder) : run_folder_(std::move(run_folder)) {}

  /// Returns false if no lease exists, if its holder released it or is known to be dead, or if no
  /// call has seen a renewal for the length of a lease. If the disk can't be read, returns true.
  bool may_live(double now_s);

 private:
  std::string run_folder_;
  std::uint64_t generation_ = 0;
  std::string text_{};
  double since_s_ = 0;  ///< first time that the lease was seen in this state
};

/// If a Look awaits a list, the list is requested earlier: after this share of list_every_s.
inline constexpr double k_list_soonest_share = 0.2;
/// Maximum delay until the record of an ended attempt is visible.
inline constexpr double k_settle_s = 5;
/// If an attempt has no record, the report has at most this many bytes of the system's and the
/// keeper's output.
inline constexpr std::size_t k_system_log_bytes = 2000;

class SystemAttempts final : public Attempts {
 public:
  struct Parts {
    rpc::Loop& loop;
    const base::Clock& clock;
    base::FileSystem& files;
    const JobFolders& folders;
    Feeds& feeds;
    std::shared_ptr<backend::Backend> backend;
    std::string daemon_id{};         ///< backend::is_daemon_name
    double list_every_s = 10;        ///< interval of lists of all attempts
    double look_every_s = k_look_s;  ///< interval of reading the folders' records
    double settle_s = k_settle_s;
    keeper::Programs programs{};  ///< as the system's machines see them
    TextOf text_of;
    Hear hear;
  };
  explicit SystemAttempts(Parts parts);
  ~SystemAttempts() override;

  void launch(const jobs::Launch& launch) override;
  void stop(const jobs::Stop& stop) override;
  void look(const jobs::Look& look) override;
  std::optional<jobs::BackendNote> look_at_programs() override {
    return sights_.look_at_programs();
  }
  std::size_t running() const override { return runs_.size(); }

 private:
  struct Run {
    jobs::Attempt attempt{};
    bool is_launching = false;     ///< no list includes it yet
    std::uint64_t since_list = 0;  ///< first list that can include it
    bool is_looked_for = false;
    bool is_stopped = false;    ///< by us
    bool is_told_gone = false;  ///< its last words are being fetched
    std::optional<backend::Seen> seen{};
    std::optional<double> gone_s{};  ///< since when the system no longer has it
    std::optional<LeaseWatch> lease{};
    bool has_begun = false;  ///< it has a record
    std::string told_words{};
    WatchedRun watched{};
  };

  void tell(jobs::Input input);
  void tell_seen(jobs::JobId job, Run& run, decltype(jobs::Sight::seen) seen);
  void tell_pending(jobs::JobId job, Run& run, std::string words);
  Run& run_of(jobs::JobId job, jobs::Attempt attempt);
  Run* find(jobs::JobId job, jobs::Attempt attempt);
  backend::AttemptName name_of(jobs::JobId job, jobs::Attempt attempt) const;
  backend::Order order_of(const jobs::Launch& launch, const LaunchText& text) const;

  /// Calls `question` in the backend's thread. The question posts its outcome to the loop.
  void ask(std::function<void()> question);
  void launched(jobs::JobId job, jobs::Attempt attempt, const backend::Seen& seen);
  void not_launched(jobs::JobId job, jobs::Attempt attempt, const std::string& words, bool is_away,
                    bool may_have_begun);
  void list();
  void list_if_due();
  double list_soonest_s() const;
  void listed(std::uint64_t number, const std::map<backend::AttemptName, backend::Seen>& all);
  void not_listed(const std::string& words);

  void poll();
  void plan_poll();
  void judge(jobs::JobId job);
  bool judge_begun(jobs::JobId job, Run& run, const keeper::AttemptRecord& record);
  bool judge_gone(jobs::JobId job, Run& run, const keeper::AttemptRecord* record);
  void judge_there(jobs::JobId job, Run& run);
  void fetch_last_words(jobs::JobId job, Run& run);
  bool is_folder_gone(jobs::JobId job, Run& run);
  bool is_gone(const Run& run) const;
  jobs::Outside outside_of(const Run& run) const;
  std::string words_of(const Run& run) const;

  Parts parts_;
  AttemptSights sights_;
  std::map<jobs::JobId, Run> runs_;
  rpc::Loop::Handle polling_{};
  rpc::Loop::Handle listing_{};
  bool is_polling_ = false;
  bool is_listing_ = false;
  std::optional<double> list_begun_s_{};  ///< begin of the newest list
  std::uint64_t lists_ = 0;               ///< number of lists begun
  Worker worker_;                         ///< last member: its work uses the others
};

}  // namespace sleight::daemon
