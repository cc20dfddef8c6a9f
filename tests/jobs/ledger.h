// What must hold, whatever happens: told of everything that is saved, answered, launched and really
// runs, it says what is wrong first.
//
// Numbered rules
//   1. Each save's histories go on from the states before, and end in those that it saves.
//   2. A job is over once, unless its user extended or resumed it; no program of one that is over
//      begins.
//   3. A launch is of the attempt that the store has as open; a stop of one that is to stop or that
//      isn't the newest; a removal of a job that is leaving; an answer says what is stored.
//   4. At most one program of a job runs, and each has a newer attempt than all before.
//   5. Cores and memory of open attempts, as stored, are within the machine's and the user's limit
//      whenever one is added; where all news are true, those of programs that run are too.
//   6. No attempt is added while the disk is known to be low, the server drained or the backend
//   away.
//   7. A user's jobs that aren't over are within its limit when one is submitted.
//   8. A key is one job's, and an id is never given again.
//   9. A job is done when its program finished, and fails as its program does; five deaths that
//   were
//      told without a commit between, and no fewer, or a bug twice, make it fail.
//  10. After the n-th start in a row that failed the next comes 2^(n-1) s later at the soonest.
//  11. A job that nobody deletes is told of announce_s before it is, and is not pinned.
//  12. A running job that is to stop is told so in the same step.
//  13. One whose attempt somebody cancelled in the batch system, and that nobody had asked to stop,
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

  // What the daemon is told, and what it does
  /// Before the machine takes it.
  void tells(const Input& input, const Jobs& machine);
  /// What comes of a step, before any of it is carried out.
  void decides(const std::vector<Effect>& effects, const Jobs& machine);
  /// Becomes durable now.
  void saves(const Save& save, const SimStore& before);
  void carries_out(const Effect& effect, const SimStore& store);
  /// Another daemon begins, with what is stored.
  void restarts(const SimStore& store);

  // What is so
  void is_planned(JobId job, const JobPlan& plan);
  void user_asks(JobId job, AskKind kind);
  void program_begins(JobId job, Attempt attempt, std::uint32_t cores, std::uint64_t memory_bytes,
                      const SimStore& store);
  void program_ends(JobId job, Attempt attempt);
  void is_finished(JobId job, std::uint64_t revision) { finished_[job] = revision; }

  /// What is wrong first; empty: nothing.
  const std::string& violation() const { return violation_; }
  std::uint64_t launches() const { return launches_; }
  std::uint64_t announcements() const { return announcements_; }

 private:
  struct Live {
    Attempt attempt;
    std::uint32_t cores = 0;
    std::uint64_t memory_bytes = 0;
  };
  /// What was told of a job, as far as it is stored what came of it.
  struct Told {
    std::uint64_t scans_told = 0;
    std::uint32_t deaths = 0;  ///< in a row without a commit
    std::uint64_t scans_at_death = 0;
    bool has_bug = false;
    std::uint64_t scans_at_bug = 0;
    bool is_bug_again = false;
    double not_before_s = 0;  ///< service time of its next start
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
  double clock_s_ = 0;  ///< service time of the save that is looked at
  std::map<JobId, Live> live_;
  std::map<JobId, Attempt> newest_begun_;
  std::map<JobId, std::uint64_t> finished_;  ///< revision
  std::map<JobId, const JobPlan*> plans_;
  std::map<JobId, Told> told_;
  std::map<std::pair<JobId, Attempt>, ToldEnd> ends_;  ///< by the daemon that is up
  std::map<JobId, std::uint64_t> revivals_;            ///< asked for and not made use of
  std::map<JobId, double> announced_;                  ///< service time of the announcement
  std::set<JobId> deleted_by_user_;
  std::set<JobId> ids_;
  std::map<std::pair<UserId, std::string>, JobId> keys_;
  std::uint64_t launches_ = 0;
  std::uint64_t announcements_ = 0;
  std::string violation_;
};

}  // namespace sleight::jobs::simulated
