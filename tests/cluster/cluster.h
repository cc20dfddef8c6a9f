// A simulated cluster: workers, a coordinator that may die and begin again, a store and a network,
// on one simulated clock, with the faults of a schedule. What it runs is real: plans, scheduler,
// block runner, sample cache.
//
//   faults ──▶ workers ◀── network ──▶ coordinator (session 1, 2, ...) ──▶ store
//
// Invariant: a run is a function of its scenario. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/cluster/event_queue.h"
#include "tests/cluster/network.h"
#include "tests/cluster/scenario.h"
#include "tests/cluster/sim_coordinator.h"
#include "tests/cluster/sim_store.h"
#include "tests/cluster/sim_worker.h"

namespace sleight::cluster {

struct Outcome {
  bool is_finished = false;
  double end_s = 0;
  double quiet_s = 0;  ///< when faults had stopped
  std::uint64_t digest = 0;
  std::string violation;   ///< of the store's invariants
  std::string difference;  ///< from the serial run
  std::uint64_t sessions = 0;
  std::uint64_t events = 0;
  core::Counts counts{};  ///< of all sessions
  /// Shares of all threads' time, of those too that were dead or not there yet: what the kept scans
  /// cost, from the beginning to the end; and what was worked between the times at which a
  /// fifth and four fifths of the scans were there.
  double utilisation = 0;
  double utilisation_amid = 0;
};

class Cluster {
 public:
  explicit Cluster(const Case& of);

  /// To the run's end, or until `limit_s` of simulated time after faults have stopped.
  Outcome run(double limit_s);

 private:
  void begin_session();
  void end_session();
  void strike(const Fault& fault);
  void for_workers(const Fault& fault, const std::function<void(SimWorker&)>& action);
  void change_weather(const Fault& fault, bool begins);
  void calm_down();
  void note_progress();

  const Case& case_;
  const Scenario& scenario_;
  double scans_;  ///< that there will be
  EventQueue events_;
  Network network_;
  Dice dice_;
  base::ManualClock work_clock_;
  Meter meter_;
  SimStore store_;
  std::vector<std::unique_ptr<SimWorker>> workers_;
  std::shared_ptr<SimCoordinator> coordinator_;
  std::vector<Fault> bad_weather_;  ///< that blows now
  Outcome outcome_;
  struct Mark {
    double at_s = 0;
    double thread_s = 0;
  };
  std::vector<Mark> marks_;
  std::uint64_t assigned_ = 0;
};

/// How long after the last fault a run may take at most. Everything that is out when faults stop
/// comes back or is given out again within the longest lease; then the work left, at most all of
/// it, is done by the threads that are there, no faster than one replica's scans one by one; twice,
/// since blocks are given out twice when leases are short.
double liveness_bound_s(const Case& of);

}  // namespace sleight::cluster
