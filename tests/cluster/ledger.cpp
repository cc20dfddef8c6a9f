#include "tests/cluster/ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <utility>

#include "common/base/check.h"
#include "tests/cluster/hash_worker.h"

namespace sleight::cluster {
namespace {

std::uint64_t digest_of(std::uint64_t hash, const plan::ScanRecord& record) {
  hash = mixed(hash, std::bit_cast<std::uint64_t>(record.log_constraint));
  hash = mixed(hash, std::bit_cast<std::uint64_t>(record.inverse_temperature));
  hash = mixed(hash, record.lineage * 2 + (record.satisfied ? 1 : 0));
  for (const std::uint32_t count : record.accepted)
    hash = mixed(hash, count);
  for (const std::byte byte : record.state)
    hash = mixed(hash, std::to_integer<std::uint64_t>(byte));
  return hash;
}

}  // namespace

bool Ledger::continues(const plan::UnitResult& result) const {
  const auto found = replicas.find(result.unit.replica);
  if (result.scans.size() != result.unit.scans) return false;
  return found == replicas.end() || found->second.next_scan() == result.unit.first_scan.value;
}

void Ledger::add(plan::UnitResult result) {
  CHECK(continues(result));
  Replica& replica = replicas[result.unit.replica];
  if (replica.scans.empty()) replica.first_scan = result.unit.first_scan.value;
  std::ranges::move(result.scans, std::back_inserter(replica.scans));
  replica.state = std::move(result.state_after);
}

std::uint64_t Ledger::scans() const {
  std::uint64_t sum = 0;
  for (const auto& [key, replica] : replicas)
    sum += replica.scans.size();
  return sum;
}

std::uint64_t digest_of(const Ledger& ledger) {
  std::uint64_t hash = 0;
  for (const auto& [key, replica] : ledger.replicas) {
    hash = mixed(mixed(hash, key.chain.value), key.replica.value);
    hash = mixed(mixed(hash, replica.first_scan), replica.scans.size());
    for (const plan::ScanRecord& record : replica.scans)
      hash = digest_of(hash, record);
    for (const std::byte byte : replica.state)
      hash = mixed(hash, std::to_integer<std::uint64_t>(byte));
  }
  return hash;
}

std::string difference(const Ledger& expected, const Ledger& found) {
  if (digest_of(expected) == digest_of(found)) return {};
  for (const auto& [key, there] : expected.replicas) {
    const auto name = fmt::format("chain {} replica {}", key.chain.value, key.replica.value);
    const auto other = found.replicas.find(key);
    if (other == found.replicas.end()) return name + " is missing";
    const Ledger::Replica& here = other->second;
    if (here.first_scan != there.first_scan) return name + " begins at another scan";
    const std::size_t both = std::min(here.scans.size(), there.scans.size());
    for (std::size_t i = 0; i < both; ++i) {
      if (digest_of(0, here.scans[i]) != digest_of(0, there.scans[i]))
        return fmt::format("{} differs at scan {}", name, there.first_scan + i);
    }
    if (here.scans.size() != there.scans.size())
      return fmt::format("{} has {} scans, not {}", name, here.scans.size(), there.scans.size());
    if (here.state != there.state) return name + " has another state at its end";
  }
  return "replicas that should not be";
}

Ledger run_serially(plan::Plan& plan, const plan::UnitWorker& worker) {
  Ledger ledger;
  while (!plan.finished()) {
    const std::optional<plan::Unit> unit = plan.next_unit(1);
    CHECK(unit.has_value());
    const base::Bytes before = unit->starts ? base::Bytes{} : ledger.replicas[unit->replica].state;
    plan::UnitResult result = worker.run(*unit, before);
    plan.consume(unit->replica, unit->first_scan, result.scans);
    ledger.add(std::move(result));
  }
  return ledger;
}

}  // namespace sleight::cluster
