// Carries out a plan: sends the scheduler's assignments (service/core) to the crew, puts results
// into the store, and reports progress. Serial, threaded and MPI runs differ only in the crew.
//
// Neither the loop nor the crew makes decisions that could change a result.
#pragma once

#include <functional>
#include <span>

#include "common/base/clock.h"
#include "common/events/progress.h"
#include "common/plan/plan.h"
#include "common/request/direction_request.h"
#include "common/store/run_store.h"
#include "service/coordinator/crew.h"
#include "service/core/scheduler.h"

namespace sleight::coordinator {

/// What a session did besides computing, for people who tune runs.
struct Handling {
  core::Counts counts{};
  Traffic traffic{};
  plan::CacheUse cache{};  ///< of all workers, as last reported
};

/// The cut of the results that the plan has consumed.
request::Cut cut_of(const plan::Plan& plan);

/// A run's state, for checkpoints.
struct Standing {
  request::Cut reached{};  ///< perhaps not committed yet
  bool has_solution = false;
  bool has_finds = false;   ///< all requested finds of a search
  std::size_t workers = 1;  ///< computing threads
};

/// Default time to wait for blocks in progress after a stop. Most units take milliseconds, and a
/// person should not wait longer.
inline constexpr double k_stop_grace_s = 2;

struct DriveOptions {
  double time_limit_s = 0;  ///< 0: no limit
  /// Maximum wait for blocks in progress after a stop. The next session computes the rest.
  double stop_grace_s = k_stop_grace_s;
  double report_every_s = 0.1;
  std::function<bool()> stop_requested{};  ///< called often; may be empty
  std::function<void()> stopping{};        ///< called once, at a stop request; may be empty
  std::function<void(const events::Progress&)> report{};  ///< may be empty
  double log_natural_throw = 0;                           ///< as WorldLayout has it
  /// Receives the run's state every report_every_s and at a search's last find. Must be quick. May
  /// be empty.
  std::function<void(const Standing&)> standing{};
  /// Receives all results: first the results of earlier sessions, then each new result before it is
  /// stored. The results of each replica arrive in order. May be empty. `standing` can use what the
  /// plan derived from these results.
  std::function<void(const plan::ReplicaKey&, base::ScanIndex first_scan,
                     std::span<const plan::ScanRecord>)>
      consumed{};
  /// Receives this session's failed simulations. Each failure arrives once, and a unit has at most
  /// a few failures. May be empty.
  std::function<void(const plan::ReplicaKey&, const plan::FailedSimulation&)> failed{};
  bool strict = false;  ///< a failed simulation, even of an earlier session, ends the run
};

enum class DriveEnd { finished, time_limit, stop_requested, simulation_failed };

struct DriveOutcome {
  DriveEnd end = DriveEnd::finished;
  request::Cut reached{};  ///< committed
  events::Progress progress{};
  Handling handling{};
};

/// Runs the plan from the store's state until it is finished or stopped. On return, all received
/// results are committed. If a stop took longer than stop_grace_s, the crew may still be computing.
/// REQUIRES: `plan` is fresh.
DriveOutcome drive(plan::Plan& plan, store::RunStore& store, Crew& crew, const base::Clock& clock,
                   const DriveOptions& options);

}  // namespace sleight::coordinator
