// A simulated run: its plan, cluster, faults and expected result. A seed determines the run.
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
/// Minimum units (scans of one replica) per worker in a run.
inline constexpr std::uint64_t k_units_per_worker = 20;

enum class Method { independent, islands, tempering, simulated_tempering, annealed_importance };

struct Scenario {
  std::uint64_t seed = 1;
  Method method = Method::independent;
  std::function<std::unique_ptr<plan::Plan>()> make_plan;  ///< returns a new plan
  std::uint64_t swap_seed = 1;
  std::uint32_t workers = 1;
  std::uint32_t threads_max = 1;  ///< per worker; some have fewer
  HashWorkerOptions work{};
  core::SchedulerOptions scheduler{};
  Latency latency{};
  double handling_s = 50e-6;     ///< the coordinator's time per message
  double tick_s = 0.01;          ///< interval of clock ticks
  double commit_every_s = 0.05;  ///< interval of commits
  double hello_every_s = 0.1;    ///< interval of an idle worker's hello
  double restart_s_max = 0.02;   ///< delay before another coordinator begins
  std::vector<Fault> faults{};
  Mistake mistake = Mistake::none;

  std::uint32_t threads_of(std::uint32_t worker) const { return 1 + worker % threads_max; }
};

struct Case {
  Scenario scenario;
  Ledger expected;       ///< of the serial run
  double work_s = 0;     ///< of all scans
  double longest_s = 0;  ///< of one replica's scans
  std::string name() const;
};

struct CaseChoice {
  std::optional<Method> method{};  ///< empty: chosen by the seed
  std::uint32_t workers_max = k_workers_max;
  Mistake mistake = Mistake::none;
};

/// Draws a case: workers, enough work for them, and faults. The number of workers is log-uniform up
/// to the maximum.
Case case_of(std::uint64_t seed, const CaseChoice& choice = {});

/// Sets the expected result, by running the plan serially. REQUIRES: everything but the faults is
/// set.
void expect_serial(Case& of);

}  // namespace sleight::cluster
