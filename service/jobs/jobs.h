// The machine of jobs: what becomes of each, as a pure state machine. An input goes in, effects
// come out; it knows no process, file, socket, clock or thread.
//
// Idea. A job is a run that is started again until it comes to an end. Since a run goes on where
// its store is, and stopping in order loses nothing, a job may be stopped and started as often as
// is good for others: so jobs are processes that share a machine in slices of some ten seconds.
//
//   inputs ──▶ step ──▶ Save, then Launch, Stop, Look, Answer, Remove, Announce
//              │ ends.h     what a job's end means
//              │ turns.h    who is next, with how many cores, and who makes room
//              │ keeping.h  which finished jobs are deleted, and when that is said
//
// What it relies on, of a job's folder (the keeper's invariants), and nothing else:
//   K1. At most one keeper is in a folder.
//   K2. A keeper of attempt n does nothing if the folder's record is of n or a newer attempt.
//   K3. The record is durable before the program starts, and again when all its processes are gone.
// So to launch an attempt again is safe (K1, K2), and "never began" is no proof that it won't
// begin: a Launch of a daemon that was killed may be under way. To be rid of such an attempt the
// machine launches it again, sees it, and stops it.
//
// Invariants
//   1. A job's state changes only in a Save, with a Change; the Save is its step's first effect. So
//      whatever was told or started is in the job store, and a machine made from the store goes on.
//   2. A job is over at most once, unless its user extends or resumes it.
//   3. At most one attempt of a job is open; only its sights count. A keeper of another one that is
//      seen is stopped.
//   4. Cores and memory of open attempts never exceed the newest Room's when one is launched, nor
//      a user's cores its limit.
//   5. What comes out is a function of the options, the restored records and the inputs' order.
//   6. Of waiting jobs the next one is never overtaken by one that comes after it (turns.h), so a
//      large one gets its room.
//
// A batch system may have an attempt in its queue first: the job stays `starting` with its cores
// kept for it, and nothing is charged. How long that takes is that system's.
//
// Nobody starves: a user that waits with nothing running is next after patience_s at the latest; it
// has its room when the running jobs' slices are over (a slice is bounded by slice_per_cost times a
// job's restart, or by twice the time that its longest scan takes) and they have stopped
// (stop_now_after_s at most). So a user waits at most patience_s and, for each user that is before
// it for the same reason, one slice and one stop. Within a user, a job waits for those before it;
// but each patience_s the one that has waited longest is next.
//
// A step costs the logarithm of the number of jobs, and is linear in users that wait and in running
// jobs; only a Room with other cores or memory looks at all jobs.
//
// Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
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

/// What the job store has. A fresh one is as below.
struct Restored {
  double clock_s = 0;
  std::uint64_t next_id = 1;
  std::vector<Job> jobs{};
  std::vector<Usage> usages{};
};

/// Why a queued job isn't running yet.
enum class WhyNot {
  next,          ///< it would start if there were room: running jobs make some after their slices
  others_first,  ///< jobs are before it
  back_off,      ///< it failed; until next_start_s
  limit_cores,   ///< its user has all the cores that it may have
  limit_core_hours,
  too_large,  ///< for this machine as it is now
  draining,
  disk_low,
  backend_away,
  not_known_yet  ///< the daemon has only begun
};

struct Waiting {
  WhyNot why = WhyNot::next;
  /// 1: it is next; 0: it waits for something else than its turn. Counted as if users took turns;
  /// k_place_max: that or more.
  std::uint64_t place = 1;
  std::string sentence{};
};

/// How the server stands, for its status.
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
  /// REQUIRES: the records are what Saves of one store came to. The first inputs are a Tick, then
  /// Began; sights are asked for then, of all jobs that had an open attempt.
  explicit Jobs(const Options& options, Restored restored = {});
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  std::vector<Effect> step(const Input& input);

  /// What a submit would be refused for now, if so many new jobs of its user came before it: for
  /// those who submit several jobs or none. None also where it is a job that is there.
  std::optional<Refusal> refusal_of(const Submit& input, std::uint64_t before_it = 0) const;

  const Job* find(JobId id) const;
  /// All that aren't deleted or leaving, and those that are leaving.
  const std::map<JobId, Job>& all() const { return jobs_; }
  /// REQUIRES: the job is queued.
  Waiting waiting(JobId id) const;
  Standing standing() const;
  /// By the ticks' clock: when a Tick is wanted at the latest; none: not before another input.
  std::optional<double> next_tick_s() const;
  /// Service time as of the last tick.
  double clock_s() const { return clock_s_; }

 private:
  /// What is known of an open attempt beside the job's record; not stored.
  struct Open {
    bool has_begun = false;                ///< its keeper has been seen
    bool is_looked_for = false;            ///< a Look is out
    bool is_pending = false;               ///< a batch system has it in its queue
    bool is_found = false;                 ///< its launch was an earlier daemon's
    bool is_launched_again = false;        ///< so an earlier launch may still be under way
    std::uint32_t unbegun = 0;             ///< answers in a row that it never began
    double charged_s = 0;                  ///< its cores are counted up to here
    std::optional<double> alarm_s{};       ///< its place in alarms_
    std::optional<double> stop_asked_s{};  ///< since when it is to stop
    bool is_ended_now = false;             ///< it was asked for long enough
  };

  // jobs.cpp: inputs that are about all jobs, and a job's way from state to state
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

  // jobs_asks.cpp: what people ask for
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

  // jobs_sights.cpp: what is seen of open attempts
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

  // jobs_turns.cpp: who starts, and who makes room
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
  std::set<JobId> held_;  ///< that go on by themselves, but for those of limits:
  std::set<std::pair<UserId, JobId>> limited_;
  std::set<JobId> unfit_;                       ///< queued, too large for the machine as it is
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
