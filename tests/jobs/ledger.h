// Checks the rules of the service. The ledger receives all inputs, saves, answers, launches and
// program events, and reports the first violation.
//
// Numbered rules
//   1. In each save, a job's history starts at its earlier state and ends at its saved state.
//   2. A job ends once, unless its user extends or resumes it. After a job's end, its program
//      doesn't start.
//   3. Only the stored open attempt is launched. An attempt is stopped only if it should stop or
//      isn't the newest attempt. Only a leaving job is removed. An answer matches the store.
//   4. At most one program of a job runs at a time. Each program of a job belongs to a newer
//      attempt than the job's earlier programs.
//   5. When an attempt is added, the stored open attempts are within the machine's and the user's
//      limits of cores and memory. If all reports are true, the running programs are within these
//      limits too.
//   6. No attempt is added while the disk is reported low, the server is draining, or the backend
//      is reported unreachable.
//   7. At each submit, a user's unfinished jobs are within the limit.
//   8. A key belongs to one job, and an id is never reused.
//   9. A job is done when its program has finished, and fails when its program fails. A job also
//      fails at the fifth reported death without a commit in between, no earlier and no later. A
//      job also fails if the same bug occurs twice.
//  10. After n consecutive failed starts, the next start is at least 2^(n-1) s later.
//  11. A job's deletion is announced announce_s in advance, unless a user deletes the job. Pinned
//      jobs aren't deleted.
//  12. The step that decides to stop a running job also sends the stop.
//  13. If somebody cancels a job's attempt in the batch system and no stop was requested, the job
//      is held, or done if it had finished.
// Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/jobs/scenario.h"
#include "tests/jobs/sim_store.h"

namespace sleight::jobs::simulated {

class Ledger {
 public:
  explicit Ledger(const Scenario& scenario) : scenario_(scenario) {}

  // The daemon's inputs and actions.
  /// Called before the machine receives the input.
  void tells(const Input& input, const Jobs& machine);
  /// Called with a step's effects, before the daemon carries out any of them.
  void decides(const std::vector<Effect>& effects, const Jobs& machine);
  /// Called when the save becomes durable.
  void saves(const Save& save, const SimStore& before);
  void carries_out(const Effect& effect, const SimStore& store);
  /// Called when another daemon starts with the stored jobs.
  void restarts(const SimStore& store);

  // The actual events.
  void is_planned(JobId job, const JobPlan& plan);
  void user_asks(JobId job, AskKind kind);
  void program_begins(JobId job, Attempt attempt, std::uint32_t cores, std::uint64_t memory_bytes,
                      const SimStore& store);
  void program_ends(JobId job, Attempt attempt);
  void is_finished(JobId job, std::uint64_t revision) { finished_[job] = revision; }

  /// The first violation. Empty: none.
  const std::string& violation() const { return violation_; }
  std::uint64_t launches() const { return launches_; }
  std::uint64_t announcements() const { return announcements_; }

 private:
  struct Live {
    Attempt attempt;
    std::uint32_t cores = 0;
    std::uint64_t memory_bytes = 0;
  };
  /// Sums over the reports about a job. A report counts as soon as the daemon has stored the
  /// report's consequences.
  struct Told {
    std::uint64_t scans_told = 0;
    std::uint32_t deaths = 0;  ///< consecutive, without a commit
    std::uint64_t scans_at_death = 0;
    bool has_bug = false;
    std::uint64_t scans_at_bug = 0;
    bool is_bug_again = false;
    double not_before_s = 0;  ///< service time before which the job must not start
  };
  struct ToldEnd {
    bool is_death = false;
    bool is_bug = false;
    bool is_cancelled = false;  ///< in the batch system
    std::uint64_t scans = 0;
    double lived_s = 0;
  };
  void wrong(std::string what);
  void check_room(const Job& added, const Jobs& machine);
  void check_told(JobId job, const std::vector<Effect>& effects);
  void check_submit(const Job& added, const Jobs& machine);
  void check_change(const Change& change, const Job* before);
  void count_end(const Change& change, Told& told);
  bool may_fail(const Change& change) const;
  void check_job(const Job& job, const Job* before, const Save& save);

  const Scenario& scenario_;
  std::optional<Room> room_{};
  bool is_draining_ = false;
  bool is_backend_there_ = true;
  double clock_s_ = 0;  ///< service time of the current save
  std::map<JobId, Live> live_;
  std::map<JobId, Attempt> newest_begun_;
  std::map<JobId, std::uint64_t> finished_;  ///< revision
  std::map<JobId, const JobPlan*> plans_;
  std::map<JobId, Told> told_;
  std::map<std::pair<JobId, Attempt>, ToldEnd> ends_;  ///< reported to the current daemon
  std::map<JobId, std::uint64_t> revivals_;            ///< requested and not used
  std::map<JobId, double> announced_;                  ///< service time of the announcement
  std::set<JobId> deleted_by_user_;
  std::set<JobId> ids_;
  std::map<std::pair<UserId, std::string>, JobId> keys_;
  std::uint64_t launches_ = 0;
  std::uint64_t announcements_ = 0;
  std::string violation_;
};

}  // namespace sleight::jobs::simulated
