// The numbered events of a run, in order: solutions, failures and ended rounds.
//
// Events follow from results in logical order, not in the order of arrival:
//
//   The search's starts 0, 1, 2, ... come first. Each start has its failures, then its find.
//   Scans 1, 2, ... of all chains follow. If all chains have made a scan, its events are:
//     - failures, by (chain, replica, kind);
//     - solutions that the scan decides, by (chain, scan);
//     - rounds that end with the scan, by chain.
//
// So the chains' events are reported only after the search is over. Search and chains are computed
// concurrently, but the search has priority and takes little time.
//
// Invariants
//   1. The events up to a frontier are a function of the results up to that frontier. Nothing else
//      affects events: not the frontier's steps, threads, ranks, killed processes or earlier
//      sessions.
//   2. Reported events are final: a frontier only advances. A longer [stop] adds events. With a
//      shorter [stop] or fewer finds, there are no events until the run passes the frontier. If
//      more finds are requested, the search resumes at its frontier. Its new finds then follow
//      chains' events that were already reported.
//   3. A failure is reported once per scan and kind. At most k_failures_told_max failures are
//      reported per run, but progress and summaries count all failures.
//
// Failure files aren't results. The first failures to arrive get a file (failure_files.h). Pure,
// and not thread-safe.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/events/run_event.h"
#include "common/plan/plan.h"
#include "common/store/put_events.h"

namespace sleight::coordinator {

/// Maximum failures reported per run, so that a failing simulator doesn't fill the store.
inline constexpr std::uint64_t k_failures_told_max = 1000;

class EventSequence {
 public:
  /// Returns the file of a scan's first failure of this kind. Empty: no file is stored.
  using FileOf = std::function<std::string(const plan::ReplicaKey& replica, base::ScanIndex scan,
                                           plan::FailureKind kind)>;

  /// Resumes at a frontier.
  explicit EventSequence(const store::ToldFrontier& told, FileOf file_of = {});

  /// Accepts results, including results of earlier sessions. Call before the plan's frontier passes
  /// the results.
  void consumed(const plan::ReplicaKey& replica, base::ScanIndex first_scan,
                std::span<const plan::ScanRecord> records);

  /// Returns the new events up to the plan's frontier and advances frontier(). The events have no
  /// numbers yet.
  std::vector<events::RunEvent> advance(const plan::Plan& plan);

  /// Returns the place up to which all events are reported.
  const store::ToldFrontier& frontier() const { return told_; }

 private:
  struct FailurePlace {
    std::uint64_t at = 0;  ///< scan, or number of the start
    plan::ReplicaKey replica;
    base::ScanIndex scan;
    plan::FailureKind kind{};
    friend auto operator<=>(const FailurePlace&, const FailurePlace&) = default;
  };
  /// Failures beyond the frontier: at most the number that may still be reported.
  using Waiting = std::set<FailurePlace>;

  void remember(Waiting& waiting, const FailurePlace& place) const;
  /// Returns and removes the next failure to report. Considers only failures before `end`.
  std::optional<events::Failure> next_failure(Waiting& waiting, std::uint64_t end);
  void advance_search(const plan::Plan& plan, std::vector<events::RunEvent>& events);
  void advance_chains(const plan::Plan& plan, std::vector<events::RunEvent>& events);

  store::ToldFrontier told_;
  FileOf file_of_;
  Waiting of_search_;
  Waiting of_chains_;
};

}  // namespace sleight::coordinator
