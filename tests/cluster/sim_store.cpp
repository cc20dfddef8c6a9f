#include "tests/cluster/sim_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace sleight::cluster {

std::optional<std::uint64_t> SimStore::open(double now_s) {
  pending_.clear();
  if (now_s < full_until_s_) return std::nullopt;
  if (mistake_ == Mistake::commit_dropped && !durable_.replicas.empty())
    durable_.replicas.erase(std::prev(durable_.replicas.end()));
  check_acknowledged();
  put_up_to_.clear();
  for (const auto& [key, replica] : durable_.replicas)
    put_up_to_[key] = replica.next_scan();
  return ++epoch_;
}

void SimStore::check_acknowledged() {
  for (const auto& [key, next_scan] : acknowledged_) {
    const auto found = durable_.replicas.find(key);
    if (found == durable_.replicas.end() || found->second.next_scan() < next_scan)
      note("a commit is lost");
  }
}

void SimStore::put(plan::UnitResult result) {
  const auto known = put_up_to_.find(result.unit.replica);
  const std::uint64_t first = result.unit.first_scan.value;
  if (known != put_up_to_.end() && known->second != first) {
    note(first < known->second ? "a scan is kept twice" : "a scan is left out");
    if (first > known->second) return;
    // A scan keeps its first result, as in the real store.
    const std::uint64_t again = std::min<std::uint64_t>(known->second - first, result.scans.size());
    if (again == result.scans.size()) return;
    result.scans.erase(result.scans.begin(),
                       result.scans.begin() + static_cast<std::ptrdiff_t>(again));
    result.unit.first_scan.value += again;
    result.unit.scans -= static_cast<std::uint32_t>(again);
  }
  put_up_to_[result.unit.replica] = result.unit.first_scan.value + result.unit.scans;
  pending_.push_back(std::move(result));
}

bool SimStore::commit(double now_s) {
  const Crash crash = std::exchange(crash_, Crash::none);
  if (now_s < full_until_s_ || crash == Crash::before) return false;
  // A crash may cut a group between any two results, even of one block.
  const std::size_t all = pending_.size();
  make_durable(crash == Crash::within ? dice_.whole(0, all) : all, crash == Crash::none);
  return crash == Crash::none;
}

void SimStore::make_durable(std::size_t results, bool is_acknowledged) {
  std::set<plan::ReplicaKey> seen;
  for (std::size_t i = 0; i < results; ++i) {
    const plan::ReplicaKey key = pending_[i].unit.replica;
    const auto known = durable_.replicas.find(key);
    const bool loses_state = mistake_ == Mistake::state_update_lost && !seen.insert(key).second;
    const base::Bytes before = loses_state ? known->second.state : base::Bytes{};
    durable_.add(std::move(pending_[i]));
    if (loses_state) durable_.replicas[key].state = before;
    if (is_acknowledged) acknowledged_[key] = durable_.replicas[key].next_scan();
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(results));
}

void SimStore::note(std::string violation) {
  if (violation_.empty()) violation_ = std::move(violation);
}

}  // namespace sleight::cluster
