// The machine of jobs: a pure state machine that decides what happens to each job. The machine maps
// inputs to effects and touches no process, file, socket, clock or thread.
//
// Idea. A job is a run. A job's program is started repeatedly until the run is finished. The run
// resumes from its run store, and a clean stop loses nothing. So the machine may stop and start a
// job as often as other jobs need it: jobs are like processes that share a machine in slices of
// some ten seconds.
//
// Data flow:
//   inputs ──▶ step ──▶ Save, then Launch, Stop, Look, Answer, Remove, Announce
//              │ ends.h     what a job's end means
//              │ turns.h    who is next, with how many cores, and who makes room
//              │ keeping.h  which finished jobs are deleted, and when the deletion is announced.
//
// The machine relies only on these properties of a job's folder (the keeper's invariants):
//   K1. A folder has at most one keeper.
//   K2. If the folder's record is of attempt n or a newer attempt, a keeper of attempt n does
//       nothing.
//   K3. The record is durable before the program starts. The record's end is durable only after all
//       of the program's processes have ended.
// So launching an attempt again is safe (K1, K2). "Never began" doesn't prove that the attempt
// won't begin, because a killed daemon's Launch may still be in progress. To end an attempt that
// may still begin, the machine launches it again, waits until it is seen, and stops it.
//
// Invariants
//   1. A job's state changes only in a Save that has the Change. The Save is its step's first
//      effect. So everything that was reported or started is in the job store, and a machine that
//      is restored from the store continues there.
//   2. A job becomes done, failed or cancelled at most once, unless its user extends or resumes it.
//   3. At most one attempt of a job is open, and only sights of that attempt count. If the machine
//      sees another attempt, it stops that attempt's keeper.
//   4. When an attempt is launched, open attempts stay within the newest Room's cores and memory,
//      and within their user's limit of cores.
//   5. Effects depend only on the options, the restored records and the order of inputs.
//   6. While the next job (turns.h) waits for room, no other job starts. So even a large job gets
//      its room eventually.
//
// A batch system may queue an attempt first. The job then stays `starting`, its cores stay
// reserved, and nothing is charged. The batch system decides how long the attempt waits.
//
// Nobody starves. If a user waits and none of its jobs runs, it is next after patience_s at the
// latest. The user's job gets room once the running jobs' slices are over and these jobs have
// stopped. A slice lasts at most slice_per_cost times the job's restart cost, or twice the duration
// of its longest scan. A stop is bounded by stop_now_after_s. So a user waits at most patience_s,
// then one slice and one stop for each user that has also waited patience_s. A job waits for those
// jobs of its user that precede it. But once per patience_s, the user's longest-waiting job is
// next.
//
// A step's cost is logarithmic in the number of jobs and linear in the numbers of waiting users and
// running jobs. A step visits all jobs only if a Room changes the cores or the memory.
//
// Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "service/jobs/accounts.h"
#include "service/jobs/ends.h"
#include "service/jobs/keeping.h"
#include "service/jobs/messages.h"
#include "service/jobs/options.h"
#include "service/jobs/queue.h"
#include "service/jobs/turns.h"

namespace sleight::jobs {

/// Contents of the job store. The default values describe a new store.
struct Restored {
  double clock_s = 0;
  std::uint64_t next_id = 1;
  std::vector<Job> jobs{};
  std::vector<Usage> usages{};
};

/// Why a queued job isn't running yet.
enum class WhyNot {
  next,          ///< first in line: running jobs make room after their slices
  others_first,  ///< other jobs go first
  back_off,      ///< the last attempt failed; the job waits until next_start_s
  limit_cores,   ///< the user's limit leaves too few cores free
  limit_core_hours,
  too_large,  ///< for this machine as it is now
  draining,
  disk_low,
  backend_away,
  not_known_yet  ///< the daemon has just started
};

struct Waiting {
  WhyNot why = WhyNot::next;
  /// Place in the queue if users took turns. 1: next. 0: the job doesn't wait for its turn.
  /// k_place_max: that place or a later one.
  std::uint64_t place = 1;
  std::string sentence{};
};

/// The server's state, for its status.
struct Standing {
  std::uint32_t cores = 0;
  std::uint32_t cores_in_use = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t memory_in_use = 0;
  std::uint64_t queued = 0;
  std::uint64_t active = 0;
  std::uint64_t held = 0;
  std::uint64_t over = 0;
  bool is_draining = false;
  bool is_disk_low = false;
  bool is_backend_there = true;
};

class Jobs {
 public:
  /// REQUIRES: all restored records come from one store. The first inputs are a Tick, then Began.
  /// The machine then looks at all jobs that had an open attempt.
  explicit Jobs(const Options& options, Restored restored = {});
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  std::vector<Effect> step(const Input& input);

  /// Returns why a submit would be refused now if it came after `before_it` other new jobs of the
  /// same user. Returns nothing if the submit would be accepted, or if its key names an existing
  /// job. With this function, callers submit several jobs together or none.
  std::optional<Refusal> refusal_of(const Submit& input, std::uint64_t before_it = 0) const;

  const Job* find(JobId id) const;
  /// Returns all jobs. A deleted job is included until its folder is deleted.
  const std::map<JobId, Job>& all() const { return jobs_; }
  /// REQUIRES: the job is queued.
  Waiting waiting(JobId id) const;
  Standing standing() const;
  /// Returns the latest time for the next Tick, by the clock of Tick::now_s. None: only after
  /// another input.
  std::optional<double> next_tick_s() const;
  /// Service time as of the last tick.
  double clock_s() const { return clock_s_; }

 private:
  /// State of an open attempt that the job's record doesn't have. It isn't stored.
  struct Open {
    bool has_begun = false;                ///< its keeper has been seen
    bool is_looked_for = false;            ///< a Look is unanswered
    bool is_pending = false;               ///< a batch system has it in its queue
    bool is_found = false;                 ///< an earlier daemon launched it
    bool is_launched_again = false;        ///< an earlier launch may still be in progress
    std::uint32_t unbegun = 0;             ///< consecutive NeverBegan answers
    double charged_s = 0;                  ///< its cores are charged up to here
    std::optional<double> alarm_s{};       ///< its place in alarms_
    std::optional<double> stop_asked_s{};  ///< when its stop was requested
    bool is_ended_now = false;             ///< the clean stop took too long
  };

  // Implemented in jobs.cpp: inputs about all jobs, and a job's changes of state
  void take(const Tick& input);
  void take(const Began& input);
  void take(const Room& input);
  void take(const Drain& input);
  void take(const BackendNote& input);
  void take(const Removed& input);
  void enter(Job& job, State to, Reason reason, std::string words);
  void note(const Job& job, State from, Reason reason, std::string words);
  void leave_indices(const Job& job);
  void join_indices(const Job& job);
  void put_into_queue(const Job& job);
  void note_idle(UserId user);
  void release_held();
  void release_limited();
  bool is_cause_gone(const Job& job) const;
  void end_delays();
  void let_go(Job& job);
  void keep_house();
  void save_use();
  void finish_step();
  double wall_at(double service_s) const { return wall_ + (service_s - clock_s_); }

  // jobs_asks.cpp: people's requests
  void take(const Submit& input);
  void take(const Ask& input);
  const Job* known(const Submit& input) const;
  std::optional<Refusal> over_job_limit(UserId user, std::uint64_t before_it = 0) const;
  std::optional<Refusal> carry_out(Job& job, const Ask& input);
  std::optional<Refusal> cancel(Job& job);
  std::optional<Refusal> hold(Job& job);
  std::optional<Refusal> resume(Job& job);
  std::optional<Refusal> extend(Job& job);
  std::optional<Refusal> remove(Job& job);
  void set_pinned(Job& job, bool pinned);
  void set_priority(Job& job, std::int32_t priority);
  void begin_anew(Job& job, Reason reason, std::string words);

  // Implemented in jobs_sights.cpp: observations of open attempts
  void take(const Sight& input);
  void take(const Launched& input);
  void take(const LaunchFailed& input);
  void see(Job& job, Open& open, const NeverBegan& seen);
  void see(Job& job, Open& open, const Pending& seen);
  void see(Job& job, Open& open, const Running& seen);
  void see(Job& job, Open& open, const Ended& seen);
  void see(Job& job, Open& open, const Died& seen);
  void see(Job& job, Open& open, const Unknown& seen);
  void hear(Job& job, const Counts& counts, std::uint64_t disk_bytes,
            const std::string& results_version);
  void learn_start_cost(Job& job, std::optional<double> first_commit_after_s, bool had_committed);
  void begins(Job& job, Open& open);
  void set_pending(Job& job, Open& open, bool is_pending);
  void close(Job& job, const Verdict& verdict, const std::string& bug_place = {});
  void look(const Job& job, Open& open);
  void launch(const Job& job);
  void ask_to_stop(Job& job, Reason reason, std::string words);
  void send_stop(const Job& job, Open& open);
  void set_alarm(JobId job, Open& open, double at_s);
  void ring_alarms();
  void charge(Job& job, Open& open);
  Surroundings around(const Job& job) const;
  bool has_other_results(const Job& job) const;

  // Implemented in jobs_turns.cpp: which jobs start, and which make room
  void hand_out();
  void start(Job& job, std::uint32_t cores, bool is_turn);
  bool may_start() const;
  bool may_have_turn(UserId user, const Job& first) const;
  std::optional<NextJob> next_job() const;
  NextJob first_of(UserId user, const Queue::OfUser& waiting) const;
  Shares shares() const;
  std::uint64_t claim_of_others(UserId user, const Shares& shares) const;
  std::uint32_t cores_kept(UserId user) const;
  std::uint32_t cores_max(const Job& job) const;
  std::uint32_t cores_free() const;
  std::uint64_t memory_free() const;
  bool fits_machine(const Job& job) const;
  std::vector<RunningJob> running_jobs() const;
  bool make_room(const NextJob& next, const Need& need, const Shares& shares);
  void use_idle_cores();
  void even_out(const std::vector<RunningJob>& running, const Shares& shares);
  void shed();
  void hold_over_limits();

  const Options options_;
  std::map<JobId, Job> jobs_;
  std::map<std::pair<UserId, std::string>, JobId> by_key_;
  std::map<JobId, Open> open_;
  std::set<JobId> held_;  ///< jobs that resume by themselves, except limited_
  std::set<std::pair<UserId, JobId>> limited_;
  std::set<JobId> unfit_;                       ///< queued, too large for the machine now
  std::set<std::pair<double, JobId>> alarms_;   ///< of open attempts
  std::set<std::pair<double, JobId>> delayed_;  ///< queued, held or leaving, not before a time
  Accounts accounts_{options_};
  Queue queue_;
  Keeping keeping_{options_};

  std::uint64_t next_id_ = 1;
  double clock_s_ = 0;
  std::optional<double> ticks_begin_s_{};  ///< the ticks' clock at service time 0
  double wall_ = 0;
  double saved_s_ = 0;  ///< when use was saved last
  bool has_begun_ = false;
  bool is_draining_ = false;
  bool is_disk_low_ = false;
  std::optional<Room> room_{};
  BackendNote backend_{};
  std::uint32_t cores_in_use_ = 0;
  std::uint64_t memory_in_use_ = 0;
  std::map<State, std::uint64_t> counts_;  ///< of jobs by state

  std::set<JobId> dirty_;  ///< to be saved by this step
  std::set<UserId> dirty_users_;
  bool saves_clock_ = false;
  Save save_;
  std::vector<Effect> effects_;
};

}  // namespace sleight::jobs
