// A simulated cluster: workers, a coordinator, a store, a network, and a schedule of faults share
// one simulated clock. The coordinator may die and start again. The simulation uses the real plans,
// scheduler, block runner and cache.
//
// Data flow:
//   faults ──▶ workers ◀── network ──▶ coordinator (session 1, 2, ...) ──▶ store.
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
  double quiet_s = 0;  ///< end of all faults
  std::uint64_t digest = 0;
  std::string violation;   ///< of the store's invariants
  std::string difference;  ///< from the serial run
  std::uint64_t sessions = 0;
  std::uint64_t events = 0;
  core::Counts counts{};  ///< of all sessions
  /// Work as a share of all threads' time, including dead threads. `utilisation` counts the kept
  /// scans of the whole run. `utilisation_amid` counts all work in the middle of the run, from a
  /// fifth to four fifths of the scans.
  double utilisation = 0;
  double utilisation_amid = 0;
};

class Cluster {
 public:
  explicit Cluster(const Case& of);

  /// Runs until the run ends, or until `limit_s` of simulated time after the last fault.
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
  double scans_;  ///< expected total
  EventQueue events_;
  Network network_;
  Dice dice_;
  base::ManualClock work_clock_;
  Meter meter_;
  SimStore store_;
  std::vector<std::unique_ptr<SimWorker>> workers_;
  std::shared_ptr<SimCoordinator> coordinator_;
  std::vector<Fault> bad_weather_;  ///< currently active
  Outcome outcome_;
  struct Mark {
    double at_s = 0;
    double thread_s = 0;
  };
  std::vector<Mark> marks_;
  std::uint64_t assigned_ = 0;
};

/// Maximum time of a run after the last fault. Each outstanding assignment returns or is assigned
/// again within the longest lease. Then the available threads do the remaining work, at most the
/// whole run's work. The work takes at least the time of one replica's scans in sequence. The
/// factor of two allows for copies, because short leases cause blocks to be assigned twice.
double liveness_bound_s(const Case& of);

}  // namespace sleight::cluster
