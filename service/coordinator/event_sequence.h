// The numbered events of a run, in order: what was found, what failed, which rounds ended.
//
// They follow from results in logical order, never in the order in which results come:
//
//   starts of the search 0, 1, 2, ...    of each its failures, then what it found
//   then scans of all chains 1, 2, ...   of each, once all chains have made it:
//                                          failures, by (chain, replica, kind)
//                                          solutions that it decides, by (chain, scan)
//                                          rounds that end with it, by chain
//
// So chains' events wait until the search is over; both are computed side by side, but a search
// goes first and takes little of a run.
//
// Invariants
//   1. What is told up to a frontier is a function of the results up to it: neither of how many
//      steps the frontier took, nor of threads, ranks, deaths or earlier sessions.
//   2. What was told stays: a frontier moves forward only. A longer [stop] tells more. A shorter
//      one tells nothing before its run is past what was told; nor does a search that was asked for
//      less. One that is asked for more goes on where its frontier is, so that what it finds then
//      comes after the chains' events that were told before.
//   3. Failures are told of each scan and kind once, the first k_failures_told_max of a run: the
//      others are counted, in progress and summaries.
//
// A failure's file is no result: of many failures those that came first have one
// (failure_files.h). Pure, and not thread-safe.
#pragma once

#include <compare>
#include <cstddef>
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

/// Of a run; a simulator that fails at every other state must not fill the store with that.
inline constexpr std::uint64_t k_failures_told_max = 1000;

class EventSequence {
 public:
  /// The file of the first failure of a kind in a scan; empty if none is kept.
  using FileOf = std::function<std::string(const plan::ReplicaKey& replica, base::ScanIndex scan,
                                           plan::FailureKind kind)>;

  /// Goes on from a frontier.
  explicit EventSequence(const store::ToldFrontier& told, FileOf file_of = {});

  /// Takes in results, those of earlier sessions too; before the plan's frontier passes them.
  void consumed(const plan::ReplicaKey& replica, base::ScanIndex first_scan,
                std::span<const plan::ScanRecord> records);

  /// What follows from the plan's having come so far, without numbers; frontier() has moved.
  std::vector<events::RunEvent> advance(const plan::Plan& plan);

  /// Up to which results all is told.
  const store::ToldFrontier& frontier() const { return told_; }

 private:
  struct FailurePlace {
    std::uint64_t at = 0;  ///< the scan, or the start's number
    plan::ReplicaKey replica;
    base::ScanIndex scan;
    plan::FailureKind kind{};
    friend auto operator<=>(const FailurePlace&, const FailurePlace&) = default;
  };
  /// Those that no frontier has passed; no more of them than may still be told.
  using Waiting = std::set<FailurePlace>;

  void remember(Waiting& waiting, const FailurePlace& place) const;
  /// The next one to be told of those before `end`.
  std::optional<events::Failure> next_failure(Waiting& waiting, std::uint64_t end);
  void advance_search(const plan::Plan& plan, std::vector<events::RunEvent>& events);
  void advance_chains(const plan::Plan& plan, std::vector<events::RunEvent>& events);

  store::ToldFrontier told_;
  FileOf file_of_;
  Waiting of_search_;
  Waiting of_chains_;
};

}  // namespace sleight::coordinator
