#include "tests/cluster/hash_worker.h"

#include <utility>

#include "common/math/elementary.h"

namespace sleight::cluster {
namespace {

/// Applies the mistake in which each worker has its own seed.
sampling::HashedWorker::Options hash_of(const HashWorkerOptions& options) {
  sampling::HashedWorker::Options hash = options.hash;
  if (options.mistake == Mistake::own_numbers) hash.seed += options.id;
  return hash;
}

}  // namespace

std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  std::uint64_t x = (a ^ b) + 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

double Costs::of(const plan::ReplicaKey& replica, std::uint64_t scan) const {
  const std::uint64_t who = mixed(mixed(seed, replica.chain.value), replica.replica.value);
  const double u = static_cast<double>(mixed(who, scan) >> 11U) * 0x1p-53;
  return least_s * math::exp(u * math::log(k_cost_spread));
}

double Costs::mean_s() const {
  return least_s * (k_cost_spread - 1) / math::log(k_cost_spread);
}

HashWorker::HashWorker(const HashWorkerOptions& options, base::ManualClock& clock)
    : options_(options),
      hashed_(hash_of(options)),
      clock_(clock),
      held_(options.states_held_bytes) {}

plan::UnitResult HashWorker::run(const plan::Unit& unit, base::BytesView state) const {
  if (unit.starts) return go_on(unit, {});
  std::optional<base::Bytes> held = take(unit);
  return go_on(unit, held ? *std::move(held) : base::Bytes(state.begin(), state.end()));
}

std::optional<plan::UnitResult> HashWorker::run_from_held(const plan::Unit& unit) const {
  std::optional<base::Bytes> held = take(unit);
  if (!held) return std::nullopt;
  return go_on(unit, *std::move(held));
}

bool HashWorker::holds(const plan::Unit& unit) const {
  if (options_.mistake == Mistake::any_version) return any_version_.contains(unit.replica);
  return held_.holds(unit.replica, unit.first_scan.value);
}

std::optional<base::Bytes> HashWorker::take(const plan::Unit& unit) const {
  if (options_.mistake != Mistake::any_version)
    return held_.take(unit.replica, unit.first_scan.value);
  const auto found = any_version_.find(unit.replica);
  if (found == any_version_.end()) return std::nullopt;
  return found->second;
}

plan::UnitResult HashWorker::go_on(const plan::Unit& unit, base::Bytes state) const {
  plan::UnitResult all{.unit = unit, .scans = {}, .state_after = std::move(state)};
  all.scans.reserve(unit.scans);
  plan::Unit one = unit;
  one.scans = 1;
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
    const std::uint64_t scan = unit.first_scan.value + nth;
    one.first_scan = base::ScanIndex{scan};
    one.starts = unit.starts && nth == 0;
    one.inverse_temperatures = {unit.inverse_temperature(nth)};
    // A draw from the prior makes no proposals, so it has no proposal scales.
    if (one.inverse_temperatures.front() == 0) {
      one.proposal_scales.clear();
    } else {
      one.proposal_scales = unit.proposal_scales;
    }
    plan::UnitResult result = hashed_.run(one, all.state_after);
    one.lineage = result.scans.front().lineage;
    all.state_after = std::move(result.state_after);
    plan::ScanRecord& record = all.scans.emplace_back(std::move(result.scans.front()));
    record.state = all.state_after;
    clock_.advance(options_.costs.of(unit.replica, scan));
  }
  if (options_.mistake == Mistake::any_version) {
    any_version_[unit.replica] = all.state_after;
  } else {
    held_.put(unit.replica, unit.first_scan.value + unit.scans, all.state_after,
              all.state_after.size());
  }
  return all;
}

}  // namespace sleight::cluster
