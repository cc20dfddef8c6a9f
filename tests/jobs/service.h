// A simulated service: users, a daemon, its store, and a backend, which share one simulated clock.
// The daemon runs the real machine of jobs, and may die at any moment.
//
// Data flow:
//   users ──▶ daemon (1, 2, ...) ──▶ store
//                 │  ▲
//   faults ──▶ backend: keepers and programs.
//
// A step's effects wait until its save is on disk. A daemon's death doesn't undo the effects that
// it has carried out. Invariant: a run is a function of its scenario. Not thread-safe.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "service/jobs/jobs.h"
#include "tests/cluster/dice.h"
#include "tests/cluster/event_queue.h"
#include "tests/jobs/ledger.h"
#include "tests/jobs/scenario.h"
#include "tests/jobs/sim_backend.h"
#include "tests/jobs/sim_store.h"

namespace sleight::jobs::simulated {

struct Outcome {
  bool is_finished = false;
  std::string violation;
  std::string unfinished;  ///< the first job that isn't over; empty: all are
  double end_s = 0;
  double core_s = 0;         ///< of all programs
  double useful_core_s = 0;  ///< of these, in committed scans
  std::uint64_t daemons = 0;
  std::uint64_t inputs = 0;
  std::uint64_t launches = 0;
  std::uint64_t announcements = 0;
  std::uint64_t events = 0;
};

class Service {
 public:
  explicit Service(const Scenario& scenario);

  /// Runs until all jobs have ended, or until `limit_s` after the last fault.
  Outcome run(double limit_s);

  /// REQUIRES: the run hasn't begun.
  void at(double time_s, std::function<void()> action) { events_.at(time_s, std::move(action)); }
  double now_s() const { return events_.now_s(); }
  const SimBackend& backend() const { return backend_; }
  /// Returns the stored job with this number, or null.
  const Job* job(std::size_t nth) const {
    const auto id = ids_.find(nth);
    return id == ids_.end() ? nullptr : store_.find(id->second);
  }

 private:
  struct Batch {
    std::optional<Save> save;
    std::vector<Effect> rest;
  };
  void begin_daemon();
  void kill_daemon();
  void hear(const Input& input);
  void step(const Input& input);
  void tick();
  void plan_tick();
  void pump();
  void commit();
  void know_new_jobs(const Save& save);
  bool carry_out(const std::vector<Effect>& effects);
  void answered(const Answer& answer);

  void submit(std::size_t nth);
  void ask(std::size_t nth, AskKind kind, Token token);
  void strike(const Fault& fault);
  void change(const Fault& fault, bool begins);
  void tell_surroundings();
  void look_around();
  std::string unfinished() const;
  double wall() const { return 1.7e9 + wall_offset_s_ + events_.now_s(); }

  const Scenario& scenario_;
  cluster::EventQueue events_;
  cluster::Dice dice_;
  SimStore store_;
  Ledger ledger_;
  SimBackend backend_;
  std::unique_ptr<Jobs> machine_;
  std::uint64_t incarnation_ = 0;  ///< of the daemon; incremented when it dies
  double ticks_begin_s_ = 0;       ///< service time 0 on this daemon's clock
  double wall_offset_s_ = 0;
  std::optional<double> tick_at_s_{};
  std::deque<Batch> batches_;
  bool is_committing_ = false;
  std::optional<std::uint64_t>
      dies_at_save_{};  ///< 0: before it; 1: after it; n: after n-1 effects
  std::vector<const Fault*> lasting_;
  std::map<std::size_t, JobId> ids_;  ///< by the job's number
  std::set<std::size_t> accepted_;    ///< jobs whose users have their answer
  std::set<Token> asks_open_;
  Token next_ask_ = 1'000'000;
  Outcome outcome_;
};

}  // namespace sleight::jobs::simulated
