// The simulated backend: folders with their records, keepers, and programs. Keepers obey K1 to K3
// of jobs.h. Programs compute, die, fail and stop as planned. The backend outlives the daemon.
// Messages in both directions may be lost, repeated, late or wrong. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "service/jobs/jobs.h"
#include "tests/cluster/dice.h"
#include "tests/cluster/event_queue.h"
#include "tests/jobs/ledger.h"
#include "tests/jobs/scenario.h"

namespace sleight::jobs::simulated {

/// Probabilities of message faults.
struct Weather {
  double lost = 0;
  double doubled = 0;
  double late = 0;
  double wrong = 0;
};

class SimBackend {
 public:
  using News = std::function<void(Input)>;
  /// `news` passes reports to the current daemon, if there is one.
  SimBackend(std::uint64_t seed, cluster::EventQueue& events, Ledger& ledger, const SimStore& store,
             News news)
      : dice_(seed, cluster::Dice::Part::network),
        events_(events),
        ledger_(ledger),
        store_(store),
        news_(std::move(news)) {}

  void is_planned(JobId job, const JobPlan& plan) { folders_[job].plan = &plan; }
  void launch(const Launch& launch);
  void stop(const Stop& stop);
  void look(const Look& look);
  void remove(JobId job);

  void set(const Weather& weather) { weather_ = weather; }
  void fill_disk(bool full) { is_disk_full_ = full; }
  void leave(bool away) { is_away_ = away; }
  void change_programs(bool other) { has_other_programs_ = other; }
  /// Takes the cores of the n-th running program. The program stops cleanly or is killed.
  void take_place(std::uint64_t nth);
  /// Cancels the n-th running or waiting job, as a person would in the batch system.
  void cancel_by_hand(std::uint64_t nth);
  /// Kills the n-th keeper that holds a folder, or all keepers. Their programs die too.
  void kill(std::uint64_t nth, bool all);

  bool anything_runs() const;
  /// Returns one user's core_s() until now.
  double core_s_of(UserId user) const;
  /// Core-seconds of all programs, and core-seconds spent on committed scans.
  double core_s() const { return core_s_; }
  double useful_core_s() const { return useful_core_s_; }

 private:
  struct Folder {
    const JobPlan* plan = nullptr;
    Attempt attempt{};                   ///< of the record
    std::optional<Ended> end{};          ///< of the record
    Outside outside = Outside::nothing;  ///< why it ended without a recorded end
    bool is_locked = false;
    std::map<Attempt, Launch> pending{};  ///< in the queue
    Attempt cancelled{};                  ///< newest attempt that was cancelled while waiting
    std::uint64_t life = 0;               ///< changes when actions in progress become void
    std::uint64_t revision = 1;
    std::uint32_t cores = 1;
    bool is_stopping = false;
    bool has_stopped_by_itself = false;
    double begin_s = 0;
    std::optional<double> first_commit_after_s{};
    std::uint64_t scans = 0;  ///< committed
    std::uint64_t found = 0;
  };
  void enqueue(const Launch& launch);
  void leave_queue(JobId job, Attempt attempt);
  void begin(const Launch& launch);
  void go_on(JobId job);
  void scan(JobId job);
  bool meets_fate(JobId job, Folder& folder);
  void end(JobId job, Ended ended);
  void stopped(JobId job);
  void die(JobId job, Outside outside = Outside::nothing);
  void release(JobId job, Folder& folder);
  void after(JobId job, double delay_s, void (SimBackend::*then)(JobId));
  Running seen_running(const Folder& folder) const;
  void tell(Input input);
  Input made_wrong(Input input);
  double latency_s();

  cluster::Dice dice_;
  cluster::EventQueue& events_;
  Ledger& ledger_;
  const SimStore& store_;
  News news_;
  Weather weather_;
  bool is_disk_full_ = false;
  bool is_away_ = false;
  bool has_other_programs_ = false;
  std::map<JobId, Folder> folders_;
  double core_s_ = 0;
  std::map<UserId, double> core_s_of_;
  double useful_core_s_ = 0;
};

}  // namespace sleight::jobs::simulated
