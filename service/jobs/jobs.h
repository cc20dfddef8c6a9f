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
  /// 1: it is next. Counted as if users took turns; k_place_max: that or more.
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

  std::vector<Effect> step(const Input& input);

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
    std::uint32_t unbegun = 0;             ///< answers that it never began
    double charged_s = 0;                  ///< its cores are counted up to here
    double alarm_s = 0;                    ///< its place in alarms_
    std::optional<double> stop_asked_s{};  ///< since when it is to stop
    bool is_found = false;                 ///< its launch was an earlier daemon's
  };

  void take(const Tick& input);
  void take(const Began& input);
  void take(const Room& input);
  void take(const Drain& input);
  void take(const BackendNote& input);
  void take(const Submit& input);
  void take(const Ask& input);
  void take(const Sight& input);
  void take(const Launched& input);
  void take(const LaunchFailed& input);
  void take(const Removed& input);

  // jobs_asks.cpp
  std::optional<Refusal> refusal_of(const Submit& input);
  std::optional<Refusal> carry_out(Job& job, const Ask& input);
  std::optional<Refusal> cancel(Job& job);
  std::optional<Refusal> hold(Job& job);
  std::optional<Refusal> resume(Job& job);
  std::optional<Refusal> extend(Job& job);
  std::optional<Refusal> remove(Job& job);
  void answer(Token token, JobId job, bool is_new, std::optional<Refusal> refusal);

  // jobs_sights.cpp
  void see(Job& job, const NeverBegan& seen);
  void see(Job& job, const Running& seen);
  void see(Job& job, const Ended& seen);
  void see(Job& job, const Died& seen);
  void see(Job& job, const Unknown& seen);
  void hear(Job& job, const Counts& counts, std::uint64_t disk_bytes,
            const std::string& results_version);
  void begins(Job& job, Open& open);
  void commits(Job& job, std::optional<double> after_s);
  void close(Job& job, const Verdict& verdict);

  // jobs_turns.cpp
  void hand_out();
  bool may_start() const;
  void start(Job& job, std::uint32_t cores, bool is_turn);
  void rebalance();
  void shed();
  void hold_over_limits();
  Shares shares() const;
  std::vector<RunningJob> running_jobs() const;
  std::uint32_t cores_max(const Job& job) const;
  bool fits_machine(const Job& job) const;
  bool has_other_results(const Job& job) const;
  std::optional<NextJob> next_job() const;
  bool make_room(const NextJob& next, const Need& need);

  // jobs.cpp
  void enter(Job& job, State to, Reason reason, std::string words);
  void enqueue(Job& job, Reason reason, std::string words);
  void put_into_queue(const Job& job);
  void leave_indices(const Job& job);
  void join_indices(const Job& job);
  void ask_to_stop(Job& job, Reason reason, std::string words);
  void send_stop(const Job& job, Open& open);
  void set_alarm(const Job& job, Open& open, double at_s);
  void ring(Job& job);
  void charge(Job& job);
  void release_held();
  bool is_cause_gone(const Job& job) const;
  void touch(const Job& job) { dirty_.insert(job.id); }
  void touch(UserId user) { dirty_users_.insert(user); }
  void keep_house();
  double wall_at(double service_s) const { return wall_ + (service_s - clock_s_); }

  Options options_;
  std::map<JobId, Job> jobs_;
  std::map<std::pair<UserId, std::string>, JobId> by_key_;
  std::map<JobId, Open> open_;
  std::set<JobId> held_;                        ///< that go on by themselves
  std::set<JobId> unfit_;                       ///< queued, too large for the machine as it is
  std::set<std::pair<double, JobId>> alarms_;   ///< of open attempts
  std::set<std::pair<double, JobId>> delayed_;  ///< queued or held, not before a time
  Accounts accounts_;
  Queue queue_;
  Keeping keeping_;

  std::uint64_t next_id_ = 1;
  double clock_s_ = 0;
  std::optional<double> clock_less_ticks_s_{};  ///< service time minus the ticks' clock
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
  Save save_;
  std::vector<Effect> effects_;
};

}  // namespace sleight::jobs
