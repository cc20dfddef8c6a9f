#include "tests/statistical/support/run_serially.h"

#include <map>

#include "common/base/check.h"

namespace sleight::statistical {

void run_serially(plan::Plan& plan, const plan::UnitWorker& worker, const Observe& observe) {
  std::map<plan::ReplicaKey, base::Bytes> states;
  while (!plan.finished()) {
    const std::optional<plan::Unit> unit = plan.next_unit(1);
    CHECK(unit.has_value());
    base::Bytes& state = states[unit->replica];
    if (unit->starts) {
      const base::BytesView start = plan.start_state(unit->replica);
      state.assign(start.begin(), start.end());
    }
    plan::UnitResult result = worker.run(*unit, state);
    if (observe) observe(result);
    plan.consume(unit->replica, unit->first_scan, result.scans);
    state = std::move(result.state_after);
  }
}

std::vector<std::vector<double>> run_and_collect(
    plan::Plan& plan, const plan::UnitWorker& worker, std::uint64_t first_scan,
    const std::function<double(const plan::ScanRecord&)>& value) {
  std::map<base::ChainId, std::map<std::uint64_t, double>> values;
  run_serially(plan, worker, [&](const plan::UnitResult& result) {
    for (std::uint64_t nth = 0; nth < result.scans.size(); ++nth) {
      const std::uint64_t scan = result.unit.first_scan.value + nth;
      const plan::ScanRecord& record = result.scans[nth];
      if (record.inverse_temperature != 1 || scan < first_scan) continue;
      CHECK(values[result.unit.replica.chain].emplace(scan, value(record)).second);
    }
  });
  std::vector<std::vector<double>> series;
  for (const auto& [chain, by_scan] : values) {
    std::vector<double>& one = series.emplace_back();
    for (const auto& [scan, number] : by_scan)
      one.push_back(number);
  }
  return series;
}

}  // namespace sleight::statistical
