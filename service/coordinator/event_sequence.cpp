#include "service/coordinator/event_sequence.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

namespace sleight::coordinator {
namespace {

/// If the replica makes starts or islands, returns the number of the start or island. Otherwise
/// returns the scan's number in archives.
std::uint64_t place_of(const plan::ReplicaKey& replica, std::uint64_t scan) {
  if (plan::is_search_lane(replica.chain)) return plan::start_number(replica.chain, scan);
  return plan::is_island_lane(replica.chain) ? plan::island_number(replica.chain, scan) : scan;
}

/// An event of the chains. The event is known once all chains have made `scans` scans.
struct Known {
  std::uint64_t scans = 0;
  std::uint32_t sort = 0;  ///< failures, solutions, rounds
  events::RunEvent event;
};

}  // namespace

EventSequence::EventSequence(const store::ToldFrontier& told, FileOf file_of)
    : told_(told), file_of_(std::move(file_of)) {}

void EventSequence::consumed(const plan::ReplicaKey& replica, base::ScanIndex first_scan,
                             std::span<const plan::ScanRecord> records) {
  if (told_.failures >= k_failures_told_max) return;
  std::uint64_t scan = first_scan.value;
  for (const plan::ScanRecord& record : records) {
    const std::uint64_t here = scan++;
    if (record.failures.total() == 0) continue;
    const bool of_search = plan::is_search_lane(replica.chain);
    const std::uint64_t at = place_of(replica, here);
    if (at < (of_search ? told_.starts : told_.scans)) continue;
    for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind) {
      if (record.failures.by_kind[kind] == 0) continue;
      remember(of_search ? of_search_ : of_chains_, {.at = at,
                                                     .replica = replica,
                                                     .scan = base::ScanIndex{here},
                                                     .kind = static_cast<plan::FailureKind>(kind)});
    }
  }
}

void EventSequence::remember(Waiting& waiting, const FailurePlace& place) const {
  waiting.insert(place);
  // If more failures wait than may still be reported, drop the last one.
  if (waiting.size() > k_failures_told_max - told_.failures)
    waiting.erase(std::prev(waiting.end()));
}

std::optional<events::Failure> EventSequence::next_failure(Waiting& waiting, std::uint64_t end) {
  if (waiting.empty() || waiting.begin()->at >= end || told_.failures >= k_failures_told_max)
    return std::nullopt;
  const FailurePlace place = waiting.extract(waiting.begin()).value();
  ++told_.failures;
  return events::Failure{.simulation = std::string(plan::name_of(place.kind)),
                         .chain = place.replica.chain.value,
                         .replica = place.replica.replica.value,
                         .scan = place.scan.value,
                         .file = file_of_ ? file_of_(place.replica, place.scan, place.kind) : ""};
}

std::vector<events::RunEvent> EventSequence::advance(const plan::Plan& plan) {
  std::vector<events::RunEvent> events;
  advance_search(plan, events);
  if (!plan.finds().is_searching()) advance_chains(plan, events);
  return events;
}

void EventSequence::advance_search(const plan::Plan& plan, std::vector<events::RunEvent>& events) {
  const std::uint64_t end = plan.starts_done();
  if (end <= told_.starts) return;
  for (const plan::Find& find : plan.finds_between(told_.starts, end)) {
    while (auto failure = next_failure(of_search_, find.start + 1))
      events.push_back({.what = *std::move(failure)});
    events.push_back({.what = events::Solution{.nth = ++told_.finds,
                                               .in_proportion = false,
                                               .chain = 0,
                                               .scan = find.start,
                                               .log_p = find.log_p}});
  }
  while (auto failure = next_failure(of_search_, end))
    events.push_back({.what = *std::move(failure)});
  told_.starts = end;
}

void EventSequence::advance_chains(const plan::Plan& plan, std::vector<events::RunEvent>& events) {
  const std::uint64_t until = plan.scans_common();
  if (until <= told_.scans) return;
  std::vector<Known> known;
  for (auto place = of_chains_.begin(); place != of_chains_.end() && place->at < until;
       place = of_chains_.begin()) {
    const std::uint64_t scans = place->at + 1;
    auto failure = next_failure(of_chains_, until);
    if (!failure) break;
    known.push_back({.scans = scans, .sort = 0, .event = {.what = *std::move(failure)}});
  }
  for (const plan::Solution& solution : plan.solutions_between(told_.scans, until)) {
    known.push_back({.scans = solution.decided,
                     .sort = 1,
                     .event = {.what = events::Solution{.nth = ++told_.solutions,
                                                        .in_proportion = true,
                                                        .chain = solution.chain.value,
                                                        .scan = solution.scan,
                                                        .log_p = solution.log_p}}});
  }
  for (const plan::EndedRound& round : plan.rounds_between(told_.scans, until)) {
    known.push_back({.scans = round.scans,
                     .sort = 2,
                     .event = {.what = events::RoundEnded{.chain = round.chain.value,
                                                          .round = round.round,
                                                          .scans = round.scans,
                                                          .swaps = round.swaps,
                                                          .round_trips = round.round_trips}}});
  }
  // Use a stable sort, because events of the same kind are already in order.
  std::ranges::stable_sort(known, {},
                           [](const Known& one) { return std::tuple(one.scans, one.sort); });
  for (Known& one : known)
    events.push_back(std::move(one.event));
  told_.scans = until;
}

}  // namespace sleight::coordinator
