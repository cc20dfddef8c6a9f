// The one loop that carries out a plan: what the scheduler (service/core) says is done, sent to the
// crew and put into the store, and people are told how it goes. Serial, threaded and MPI runs
// differ only in the crew.
//
// Neither decides anything that could change a result.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "common/base/clock.h"
#include "common/events/progress.h"
#include "common/plan/plan.h"
#include "common/request/direction_request.h"
#include "common/store/run_store.h"
#include "service/coordinator/crew.h"
#include "service/core/scheduler.h"

namespace sleight::coordinator {

/// What the session's work took besides computing, for people who tune runs.
struct Handling {
  core::Counts counts{};
  Traffic traffic{};
  plan::CacheUse cache{};  ///< of all workers together, as they said last
};

/// Where an archive of what the plan has consumed is cut.
request::Cut cut_of(const plan::Plan& plan);

/// How a run stands for an archive.
struct Standing {
  request::Cut reached{};  ///< though perhaps not committed yet
  bool has_solution = false;
  bool has_finds = false;   ///< all that a search was to find
  std::size_t workers = 1;  ///< threads that compute
};

/// Most units take milliseconds, and a person does not wait twice.
inline constexpr double k_stop_grace_s = 2;

struct DriveOptions {
  double time_limit_s = 0;  ///< 0 for none
  /// From the moment when it is to stop, so long it waits for what is being computed; the rest is
  /// computed again by the next session.
  double stop_grace_s = k_stop_grace_s;
  double report_every_s = 0.1;
  std::function<bool()> stop_requested{};                 ///< asked often; may be empty
  std::function<void()> stopping{};                       ///< once, when asked to; may be empty
  std::function<void(const events::Progress&)> report{};  ///< may be empty
  double log_natural_throw = 0;                           ///< as WorldLayout has it
  /// Hears every report_every_s, and as soon as a search has its finds, how the run stands; must
  /// not take long; may be empty.
  std::function<void(const Standing&)> standing{};
  /// Hears of all results, those of earlier sessions first, before they are put into the store, of
  /// each replica in order; may be empty. What the plan makes of them can be asked in `standing`.
  std::function<void(const plan::ReplicaKey&, base::ScanIndex first_scan,
                     std::span<const plan::ScanRecord>)>
      consumed{};
  /// Hears of simulations that failed in this session, once each, of a unit the first few; may be
  /// empty.
  std::function<void(const plan::ReplicaKey&, const plan::FailedSimulation&)> failed{};
  bool strict = false;  ///< a failed simulation ends the run, one of an earlier session too
};

enum class DriveEnd { finished, time_limit, stop_requested, simulation_failed };

struct DriveOutcome {
  DriveEnd end = DriveEnd::finished;
  request::Cut reached{};  ///< committed
  events::Progress progress{};
  Handling handling{};
};

/// Runs the plan from where the store stands until it is finished or asked to stop; on return all
/// results that came are committed. The crew may still be computing after stop_grace_s. REQUIRES:
/// `plan` is fresh.
DriveOutcome drive(plan::Plan& plan, store::RunStore& store, Crew& crew, const base::Clock& clock,
                   const DriveOptions& options);

}  // namespace sleight::coordinator
