// One simulated run: its plan, its cluster and what goes wrong, all from a seed, and what it must
// come to.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/plan/plan.h"
#include "service/core/scheduler.h"
#include "tests/cluster/faults.h"
#include "tests/cluster/hash_worker.h"
#include "tests/cluster/ledger.h"
#include "tests/cluster/network.h"

namespace sleight::cluster {

inline constexpr std::uint32_t k_workers_max = 4096;
/// A run has at least so many units (scans of one replica) for each worker.
inline constexpr std::uint64_t k_units_per_worker = 20;

enum class Method { independent, islands, tempering, simulated_tempering, annealed_importance };

struct Scenario {
  std::uint64_t seed = 1;
  Method method = Method::independent;
  std::function<std::unique_ptr<plan::Plan>()> make_plan;  ///< a fresh one
  std::uint64_t swap_seed = 1;
  std::uint32_t workers = 1;
  std::uint32_t threads_max = 1;  ///< of a worker; some have fewer
  HashWorkerOptions work{};
  core::SchedulerOptions scheduler{};
  Latency latency{};
  double handling_s = 50e-6;     ///< the coordinator's, of a message
  double tick_s = 0.01;          ///< between two looks at the clock
  double commit_every_s = 0.05;  ///< a group waits for company
  double hello_every_s = 0.1;    ///< a worker without work says that it is there
  double restart_s_max = 0.02;   ///< until another coordinator begins
  std::vector<Fault> faults{};
  Mistake mistake = Mistake::none;

  std::uint32_t threads_of(std::uint32_t worker) const { return 1 + worker % threads_max; }
};

struct Case {
  Scenario scenario;
  Ledger expected;       ///< of the serial run
  double work_s = 0;     ///< of all scans
  double longest_s = 0;  ///< of one replica's
  std::string name() const;
};

struct CaseChoice {
  std::optional<Method> method{};  ///< else the seed's
  std::uint32_t workers_max = k_workers_max;
  Mistake mistake = Mistake::none;
};

/// Workers log-uniform in 1 to the most; a plan with enough for them; up to k_faults_max faults.
Case case_of(std::uint64_t seed, const CaseChoice& choice = {});

/// Runs the plan serially, for what must come out. `case.scenario` is complete but for faults.
void expect_serial(Case& of);

}  // namespace sleight::cluster
