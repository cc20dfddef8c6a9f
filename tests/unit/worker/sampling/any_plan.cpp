#include "tests/unit/worker/sampling/any_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <set>

#include "common/random/discrete_distributions.h"
#include "worker/sampling/swap.h"

namespace sleight::sampling {

Dice::Dice(std::uint64_t seed, std::uint64_t index)
    : stream_({.seed = seed, .purpose = random::Purpose::prior}, index) {}

std::uint64_t Dice::below(std::uint64_t count) {
  return random::UniformInteger{.count = count}.draw(stream_);
}

// A draw from the prior has no proposals, so the unit's proposal scales don't apply to it.
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

plan::UnitResult RecordingWorker::run(const plan::Unit& unit, base::BytesView state) const {
  plan::UnitResult all{.unit = unit, .scans = {}, .state_after = {state.begin(), state.end()}};
  std::uint64_t lineage = unit.lineage;
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
    const plan::Unit one = alone(unit, nth, lineage);
    plan::UnitResult result = worker_.run(one, all.state_after);
    made_[{unit.replica, one.first_scan.value}] = {one, result.scans.front(), result.state_after};
    lineage = result.scans.front().lineage;
    all.scans.push_back(std::move(result.scans.front()));
    all.state_after = std::move(result.state_after);
  }
  return all;
}

bool RecordingWorker::holds(const plan::Unit& unit) const {
  return !unit.starts && made_.contains({unit.replica, unit.first_scan.value - 1});
}

std::optional<plan::UnitResult> RecordingWorker::run_from_held(const plan::Unit& unit) const {
  if (!holds(unit)) return std::nullopt;
  const base::Bytes state = made_.at({unit.replica, unit.first_scan.value - 1}).state_after;
  return run(unit, state);
}

void AnySession::expect_next(const plan::Unit& unit) const {
  EXPECT_GE(unit.scans, 1U);
  const std::size_t betas = unit.inverse_temperatures.size();
  EXPECT_TRUE(betas == 1 || betas == unit.scans);
  const auto known = next_scan_.find(unit.replica);
  EXPECT_EQ(unit.starts, known == next_scan_.end());
  if (known == next_scan_.end()) return;
  EXPECT_EQ(unit.first_scan.value, known->second);
  for (const Running& running : running_)
    EXPECT_NE(running.result.unit.replica, unit.replica) << "runs already";
}

base::Bytes AnySession::state_before(const plan::Unit& unit) const {
  if (unit.starts) return {};
  return runs_.at({unit.replica, unit.first_scan.value - 1}).state_after;
}

void AnySession::takes(const RecordingWorker& worker, plan::UnitResult result) {
  Running& running = running_.emplace_back();
  const plan::Unit& unit = result.unit;
  for (std::size_t nth = 0; nth < result.scans.size(); ++nth)
    running.scans.push_back(worker.made({unit.replica, unit.first_scan.value + nth}));
  running.result = std::move(result);
}

bool AnySession::hand_out(std::uint32_t scans_max) {
  const std::optional<plan::Unit> unit = plan_.next_unit(scans_max);
  if (!unit) return false;
  EXPECT_LE(unit->scans, scans_max);
  expect_next(*unit);
  takes(workers_[0], workers_[0].run(*unit, state_before(*unit)));
  return true;
}

namespace {

/// Returns whether a member swaps with a level outside the block after its last scan.
bool left(const plan::LadderPart& part, const plan::UnitResult& member) {
  const auto at =
      std::ranges::find(part.inverse_temperatures, member.scans.back().inverse_temperature);
  const auto nth = static_cast<std::uint32_t>(at - part.inverse_temperatures.begin());
  const std::uint64_t scan = member.unit.first_scan.value + member.unit.scans - 1;
  const auto partner = even_odd_partner(part.first_level + nth, scan, part.levels);
  return partner && (*partner < part.first_level ||
                     *partner >= part.first_level + part.inverse_temperatures.size());
}

/// Expects results within the block's limits, and counts their properties.
void check_and_count(const plan::Block& block, const std::vector<plan::UnitResult>& results,
                     BlockShapes& shapes) {
  std::uint64_t scans = 0;
  std::set<std::uint64_t> begins;
  std::set<std::uint64_t> ends;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const plan::UnitResult& result = results[i];
    EXPECT_EQ(result.unit.replica, block.members[i].replica);
    EXPECT_EQ(result.unit.first_scan, block.members[i].first_scan);
    EXPECT_GE(result.unit.scans, 1U);
    EXPECT_EQ(result.unit.scans, result.scans.size());
    scans += result.unit.scans;
    begins.insert(result.unit.first_scan.value);
    ends.insert(result.unit.first_scan.value + result.unit.scans);
    if (!block.ladder) continue;
    EXPECT_EQ(result.unit.inverse_temperatures.size(), result.unit.scans);
    shapes.went_on += result.unit.scans > 1 ? 1 : 0;
    shapes.left += left(*block.ladder, result) ? 1 : 0;
    for (std::uint32_t nth = 1; nth < result.unit.scans; ++nth) {
      const bool moved =
          result.unit.inverse_temperature(nth) != result.unit.inverse_temperature(nth - 1);
      shapes.swapped += moved ? 1 : 0;
    }
  }
  if (!block.ladder) return;
  const plan::LadderPart& part = *block.ladder;
  EXPECT_EQ(part.inverse_temperatures.size(), block.members.size());
  EXPECT_LE(scans, std::max<std::uint64_t>(part.scans_max, block.members.size()));
  EXPECT_LE(*ends.rbegin(), part.end_scan);
  shapes.of_several += block.members.size() > 1 ? 1 : 0;
  shapes.staggered += begins.size() > 1 ? 1 : 0;
  const bool is_whole = block.members.size() == part.levels && scans > part.levels;
  shapes.whole += is_whole && *ends.begin() == part.end_scan ? 1 : 0;
  shapes.cut += scans == part.scans_max ? 1 : 0;
}

}  // namespace

bool AnySession::hand_out_block(Dice& dice, BlockShapes& shapes) {
  const plan::BlockLimits limits = {
      .unit_scans_max = static_cast<std::uint32_t>(1 + dice.below(dice.once_in(2) ? 8 : 400)),
      .block_scans_max = static_cast<std::uint32_t>(1 + dice.below(dice.once_in(2) ? 16 : 400)),
      .threads = 1 + dice.below(3),
      .whole_levels_max = static_cast<std::uint32_t>(dice.once_in(2) ? 0 : 6)};
  const std::optional<plan::Block> block = plan_.next_block(limits);
  if (!block) return false;
  if (!block->ladder) {
    EXPECT_EQ(block->members.size(), 1U);
    EXPECT_LE(block->members.front().scans, limits.unit_scans_max);
    shapes.annealing += block->members.front().inverse_temperatures.size() > 1 ? 1 : 0;
  }

  // Pass only some states. If a state is neither passed nor held by the worker, the block can't
  // run.
  const RecordingWorker& worker = workers_[dice.below(workers_.size())];
  const BlockRunner runner(worker, clock_);
  std::vector<plan::GivenState> all;
  std::vector<plan::GivenState> some;
  bool lacks = false;
  for (const plan::Unit& member : block->members) {
    expect_next(member);
    all.emplace_back(state_before(member));
    some.push_back(dice.once_in(3) ? all.back() : std::nullopt);
    if (some.back() || member.starts) continue;
    if (worker.holds(member)) ++shapes.held;
    lacks = lacks || !worker.holds(member);
  }
  std::vector<plan::UnitResult> results = run_block_(runner, *block, some);
  EXPECT_EQ(results.empty(), lacks);
  if (lacks) {
    ++shapes.lacking;
    results = run_block_(runner, *block, all);
  }
  EXPECT_EQ(results.size(), block->members.size());
  if (results.size() != block->members.size()) return false;
  check_and_count(*block, results, shapes);
  for (plan::UnitResult& result : results)
    takes(worker, std::move(result));
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
  const std::uint64_t longest = dice.once_in(2) ? 1 : 1 + dice.below(20);
  run(dice, steps, [&] { return hand_out(static_cast<std::uint32_t>(1 + dice.below(longest))); });
}

void AnySession::run_in_blocks(Dice& dice, BlockShapes& shapes, std::uint64_t steps) {
  run(dice, steps, [&] { return hand_out_block(dice, shapes); });
}

void AnySession::run(Dice& dice, std::uint64_t steps, const std::function<bool()>& hand_out) {
  // Sessions differ in how many units are in flight and in unit size.
  const std::uint64_t odds = 1 + dice.below(6);
  for (; steps > 0 && !plan_.finished(); --steps) {
    const bool hands_out = running_.empty() || !dice.once_in(odds);
    if (hands_out && hand_out()) continue;
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

void expect_told_as_counted(
    const plan::Plan& plan, std::uint64_t step,
    const std::function<double(std::uint32_t chain, std::uint64_t scan)>& log_p_of) {
  std::vector<plan::Solution> told;
  for (std::uint64_t after = 0; after < plan.scans_common(); after += step)
    std::ranges::copy(plan.solutions_between(after, std::min(after + step, plan.scans_common())),
                      std::back_inserter(told));
  std::size_t nth = 0;
  for (const plan::DrawPart& part : plan.draws().parts) {
    for (std::uint32_t chain = 0; chain < part.counted.size(); ++chain) {
      if (!part.counted[chain]) continue;
      ASSERT_LT(nth, told.size());
      const plan::Solution& solution = told[nth++];
      EXPECT_EQ(solution.chain, base::ChainId{chain});
      EXPECT_EQ(solution.scan, *part.counted[chain]);
      EXPECT_EQ(solution.decided, part.first_scan + part.count);
      EXPECT_EQ(solution.log_p, log_p_of(chain, solution.scan));
    }
  }
  EXPECT_EQ(nth, told.size());
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
