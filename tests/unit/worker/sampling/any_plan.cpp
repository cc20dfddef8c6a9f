#include "tests/unit/worker/sampling/any_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <set>

#include "common/random/discrete_distributions.h"

namespace sleight::sampling {

Dice::Dice(std::uint64_t seed, std::uint64_t index)
    : stream_({.seed = seed, .purpose = random::Purpose::prior}, index) {}

std::uint64_t Dice::below(std::uint64_t count) {
  return random::UniformInteger{.count = count}.draw(stream_);
}

namespace {

/// The nth scan of a unit, as a unit of its own. A draw from the prior has no proposals, so sizes
/// that it goes with for the scans after it are not its own.
plan::Unit alone(const plan::Unit& unit, std::uint32_t nth, std::uint64_t lineage) {
  plan::Unit one = unit;
  one.first_scan = base::ScanIndex{unit.first_scan.value + nth};
  one.scans = 1;
  one.starts = unit.starts && nth == 0;
  one.lineage = lineage;
  one.inverse_temperatures = {unit.inverse_temperature(nth)};
  if (one.inverse_temperatures.front() == 0) one.proposal_scales.clear();
  return one;
}

}  // namespace

plan::UnitResult ScanByScan::run(const plan::Unit& unit, base::BytesView state) const {
  plan::UnitResult all{.unit = unit, .scans = {}, .state_after = {state.begin(), state.end()}};
  std::uint64_t lineage = unit.lineage;
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
    plan::Unit one = alone(unit, nth, lineage);
    one.proposal_scales.insert(one.proposal_scales.end(), unit.excursion.begin(),
                               unit.excursion.end());
    plan::UnitResult result = hashed_.run(one, all.state_after);
    plan::ScanRecord& record = result.scans.front();
    if (!unit.excursion.empty() && std::to_integer<int>(result.state_after.at(3)) % 3 == 0)
      record.lineage = plan::lineage_from(unit.replica.replica, one.first_scan.value);
    lineage = record.lineage;
    all.scans.push_back(std::move(record));
    all.state_after = std::move(result.state_after);
  }
  return all;
}

bool AnySession::hand_out(std::uint32_t scans_max) {
  const std::optional<plan::Unit> unit = plan_.next_unit(scans_max);
  if (!unit) return false;
  EXPECT_GE(unit->scans, 1U);
  EXPECT_LE(unit->scans, scans_max);
  const std::size_t betas = unit->inverse_temperatures.size();
  EXPECT_TRUE(betas == 1 || betas == unit->scans);
  const auto known = next_scan_.find(unit->replica);
  // A replica starts once, and goes on where it was.
  EXPECT_EQ(unit->starts, known == next_scan_.end());
  base::Bytes state;
  if (known != next_scan_.end()) {
    EXPECT_EQ(unit->first_scan.value, known->second);
    state = runs_.at({unit->replica, known->second - 1}).state_after;
  }
  Running& running = running_.emplace_back();
  running.result.unit = *unit;
  std::uint64_t lineage = unit->lineage;
  for (std::uint32_t nth = 0; nth < unit->scans; ++nth) {
    const plan::Unit one = alone(*unit, nth, lineage);
    plan::UnitResult result = worker_.run(one, state);
    lineage = result.scans.front().lineage;
    running.result.scans.push_back(result.scans.front());
    running.scans.push_back({one, result.scans.front(), result.state_after});
    state = result.state_after;
  }
  return true;
}

void AnySession::complete(std::size_t which) {
  const Running done = running_[which];
  running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(which));
  const plan::Unit& unit = done.result.unit;
  for (std::size_t nth = 0; nth < done.scans.size(); ++nth)
    runs_[{unit.replica, unit.first_scan.value + nth}] = done.scans[nth];
  next_scan_[unit.replica] = unit.first_scan.value + done.scans.size();
  plan_.consume(unit.replica, unit.first_scan, done.result.scans);
}

void AnySession::run_serially() {
  while (!plan_.finished()) {
    ASSERT_TRUE(hand_out(1)) << "nothing is handed out, not finished";
    complete(0);
  }
}

void AnySession::run_randomly(Dice& dice, std::uint64_t steps) {
  // Some sessions keep much in flight, some little; some cut small.
  const std::uint64_t odds = 1 + dice.below(6);
  const std::uint64_t longest = dice.once_in(2) ? 1 : 1 + dice.below(20);
  for (; steps > 0 && !plan_.finished(); --steps) {
    const bool hands_out = running_.empty() || !dice.once_in(odds);
    if (hands_out && hand_out(static_cast<std::uint32_t>(1 + dice.below(longest)))) continue;
    ASSERT_FALSE(running_.empty()) << "nothing runs, nothing is handed out, not finished";
    complete(dice.below(running_.size()));
    if (::testing::Test::HasFailure()) return;
  }
}

void AnySession::complete_all(Dice& dice) {
  while (!running_.empty())
    complete(dice.below(running_.size()));
}

void AnySession::replay(const ScanRuns& stored, Dice& dice) {
  std::map<plan::ReplicaKey, std::vector<std::pair<std::uint64_t, plan::ScanRecord>>> by_replica;
  for (const auto& [place, run] : stored)
    by_replica[place.replica].emplace_back(place.scan, run.record);
  std::vector<plan::ReplicaKey> keys;
  for (const auto& [key, records] : by_replica)
    keys.push_back(key);
  const bool in_order = dice.once_in(2);
  for (std::size_t i = keys.size(); !in_order && i > 1; --i)
    std::swap(keys[i - 1], keys[dice.below(i)]);
  for (const plan::ReplicaKey& key : keys) {
    const auto& records = by_replica.at(key);
    for (std::size_t i = 0; i < records.size();) {
      const std::size_t count = std::min(records.size() - i, 1 + dice.below(60));
      std::vector<plan::ScanRecord> batch;
      for (std::size_t k = i; k < i + count; ++k)
        batch.push_back(records[k].second);
      plan_.consume(key, base::ScanIndex{records[i].first}, batch);
      i += count;
    }
    next_scan_[key] = records.back().first + 1;
  }
  runs_ = stored;
}

std::uint64_t scans_at_stop(const StopRule& stop, std::uint64_t round_scans, std::uint64_t before,
                            const ScanRuns& runs) {
  // When each lineage of each chain first satisfied at inverse temperature 1.
  std::map<std::pair<std::uint32_t, std::uint64_t>, std::uint64_t> first;
  for (const auto& [place, run] : runs) {
    if (!run.record.satisfied || run.record.inverse_temperature != 1 || place.scan < before)
      continue;
    auto& scan = first.try_emplace({place.replica.chain.value, run.record.lineage}, place.scan)
                     .first->second;
    scan = std::min(scan, place.scan);
  }
  std::uint64_t round_end = before;
  std::uint64_t length = round_scans;
  for (std::uint32_t round = 1;; ++round) {
    round_end += length;
    length *= 2;
    if (stop.scans && *stop.scans <= round_end) return *stop.scans;
    if (stop.rounds && *stop.rounds == round) return round_end;
    const auto solved = static_cast<std::uint64_t>(
        std::ranges::count_if(first, [&](const auto& entry) { return entry.second < round_end; }));
    if (stop.independent_solutions && solved >= *stop.independent_solutions) return round_end;
  }
}

void expect_equal(const plan::Report& a, const plan::Report& b) {
  EXPECT_EQ(a.warning, b.warning);
  ASSERT_EQ(a.tables.size(), b.tables.size());
  for (std::size_t t = 0; t < a.tables.size(); ++t) {
    EXPECT_EQ(a.tables[t].name, b.tables[t].name);
    EXPECT_EQ(a.tables[t].dims, b.tables[t].dims);
    ASSERT_EQ(a.tables[t].values.size(), b.tables[t].values.size());
    for (std::size_t i = 0; i < a.tables[t].values.size(); ++i) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(a.tables[t].values[i]),
                std::bit_cast<std::uint64_t>(b.tables[t].values[i]))
          << a.tables[t].name;
    }
  }
}

}  // namespace sleight::sampling
