// The one loop that carries out a plan: hand out what can run, take in what is done, store it, say
// how it goes. Serial, threaded and MPI runs differ only in the executor.
//
// The loop decides nothing that could change a result. Units are cut from measured cost, so that a
// stop is answered soon and messages stay few.
#pragma once

#include <cstdint>
#include <functional>
#include <map>

#include "common/base/clock.h"
#include "common/plan/plan.h"
#include "common/store/run_store.h"
#include "service/coordinator/executor.h"

namespace sleight::coordinator {

/// A unit should take about this long: far above the cost of handing it out, far below patience.
inline constexpr double k_unit_target_s = 0.020;
/// Scans of a unit at most: bounds the result's memory.
inline constexpr std::uint32_t k_unit_scans_max = 8192;

/// How a run stands; counts cover earlier sessions only where they say so.
struct Progress {
  std::uint64_t scans_done = 0;         ///< over all chains, earlier sessions included, committed
  std::uint64_t scans_total = 0;        ///< 0 where the stop rule can't tell
  std::uint64_t session_scans = 0;      ///< consumed in this session
  std::uint64_t session_satisfied = 0;  ///< of these, satisfied
  std::uint64_t session_proposed = 0;
  std::uint64_t session_accepted = 0;
  std::uint64_t solutions = 0;         ///< independent solutions, earlier sessions included
  std::uint64_t solutions_wanted = 0;  ///< 0 where the stop rule doesn't ask for them
  std::size_t workers = 0;
  double elapsed_s = 0;  ///< of this session
};

struct DriveOptions {
  double time_limit_s = 0;  ///< 0 for none
  double report_every_s = 0.1;
  std::function<bool()> stop_requested{};         ///< asked often; may be empty
  std::function<void(const Progress&)> report{};  ///< may be empty
  /// Called now and then between units when everything is committed up to `scans_common`, so that
  /// people who watch have a recent archive; may be empty.
  std::function<void(std::uint64_t scans_common)> checkpoint{};
  double checkpoint_every_s = 60;
};

enum class DriveEnd { finished, time_limit, stop_requested };

struct DriveOutcome {
  DriveEnd end = DriveEnd::finished;
  std::uint64_t scans_common = 0;  ///< committed for every chain: where the archive is cut
  Progress progress{};
};

/// Runs the plan from where the store stands until it is finished or asked to stop; on return all
/// results are committed. REQUIRES: `plan` is fresh.
DriveOutcome drive(plan::Plan& plan, store::RunStore& store, Executor& executor,
                   const base::Clock& clock, const DriveOptions& options);

}  // namespace sleight::coordinator
