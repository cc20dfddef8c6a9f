#include "worker/sampling/search_lanes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "tests/support/property.h"
#include "worker/sampling/search_first.h"

namespace sleight::sampling {
namespace {

/// A search whose starts succeed with a given probability.
struct Starts {
  std::uint64_t seed = 0;
  double odds = 0;
  bool finds(std::uint64_t start) const {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::search}, start);
    return stream.uniform() < odds;
  }
  /// Number of starts up to and including the n-th find.
  std::uint64_t until(std::uint64_t n) const {
    std::uint64_t start = 0;
    for (std::uint64_t found = 0; found < n; ++start)
      found += finds(start) ? 1 : 0;
    return start;
  }
};

std::vector<plan::ScanRecord> results(const Starts& starts, const plan::Unit& unit) {
  std::vector<plan::ScanRecord> records(unit.scans);
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
    const std::uint64_t start = plan::start_number(unit.replica.chain, unit.first_scan.value + nth);
    records[nth].satisfied = starts.finds(start);
    records[nth].log_prior = static_cast<double>(start);
    records[nth].log_constraint = -static_cast<double>(start) / 2;
  }
  return records;
}

/// Hands units to `workers` workers until no units are left or `results_max` results have arrived.
/// Results arrive in any order. Units that are in flight at that moment are lost.
void work(SearchLanes& lanes, const Starts& starts, std::size_t workers, random::Stream& stream,
          std::uint64_t results_max = UINT64_MAX) {
  std::vector<plan::Unit> out;
  for (std::uint64_t came = 0; came < results_max; ++came) {
    while (out.size() < workers) {
      const auto unit = lanes.next_unit(
          static_cast<std::uint32_t>(1 + random::UniformInteger{.count = 9}.draw(stream)));
      if (!unit) break;
      EXPECT_TRUE(unit->starts && unit->searches());
      out.push_back(*unit);
    }
    if (out.empty()) return;
    const auto which = random::UniformInteger{.count = out.size()}.draw(stream);
    std::swap(out[which], out.back());
    lanes.consume(out.back().replica.chain, out.back().first_scan, results(starts, out.back()));
    out.pop_back();
  }
}

TEST(SearchLanes, FindTheSameWhoeverSearches) {
  // Goal: a search ends with exactly the requested number of finds. The finds come from the first
  // starts that succeed. Workers, cuts of units, order and sessions have no effect on the result. A
  // request for more finds extends the search. Method: compare random runs with a loop over the
  // starts.
  for (const std::uint64_t i : property::cases(300)) {
    random::Stream stream({.seed = i, .purpose = random::Purpose::scene}, 0);
    const Starts starts{.seed = i, .odds = 0.3 + 0.7 * stream.uniform()};
    const std::uint64_t wanted = 1 + random::UniformInteger{.count = 400}.draw(stream);
    const std::size_t workers = 1 + random::UniformInteger{.count = 100}.draw(stream);
    SearchLanes lanes(i, wanted);
    const bool in_sessions = stream.uniform() < 0.5;
    work(lanes, starts, workers, stream,
         in_sessions ? random::UniformInteger{.count = 400}.draw(stream) : UINT64_MAX);
    if (in_sessions) {
      // A fresh plan resumes from stored results: for each lane, from all results before the lane's
      // first gap.
      SearchLanes again(i, wanted + 5);
      const std::uint64_t per_lane = (lanes.starts() + 32) / plan::k_search_lanes;
      for (std::uint32_t lane = 0; lane < plan::k_search_lanes && per_lane > 0; ++lane) {
        const plan::Unit unit{.replica = {base::ChainId{plan::k_first_lane + lane}, {}},
                              .first_scan = {},
                              .scans = static_cast<std::uint32_t>(per_lane)};
        again.consume(unit.replica.chain, {}, results(starts, unit));
      }
      work(again, starts, workers, stream);
      EXPECT_EQ(again.finds().found, wanted + 5);
      EXPECT_GE(again.starts(), starts.until(wanted + 5));
      continue;
    }
    EXPECT_TRUE(lanes.finished());
    EXPECT_FALSE(lanes.finds().gave_up);
    EXPECT_EQ(lanes.finds().found, wanted);
    EXPECT_GE(lanes.starts(), starts.until(wanted));
    // Request the finds in two portions, and check each find's start.
    EXPECT_EQ(lanes.starts_done(), starts.until(wanted));
    const std::uint64_t half = lanes.starts_done() / 2;
    std::vector<plan::Find> told = lanes.finds_between(0, half);
    std::ranges::copy(lanes.finds_between(half, lanes.starts_done()), std::back_inserter(told));
    ASSERT_EQ(told.size(), wanted);
    EXPECT_TRUE(std::ranges::is_sorted(told, std::ranges::less_equal{}, &plan::Find::start));
    for (const plan::Find& find : told) {
      ASSERT_TRUE(starts.finds(find.start));
      ASSERT_EQ(find.log_p, static_cast<double>(find.start) / 2);
    }
  }
}

TEST(SearchLanes, HardlySearchesTooMuch) {
  // Goal: if every start succeeds, the search wastes no start. Starts in flight never outnumber the
  // missing finds. Method: let one worker request units until the search has no more units.
  SearchLanes lanes(1, 5);
  std::vector<plan::Unit> out;
  while (const auto unit = lanes.next_unit(100))
    out.push_back(*unit);
  ASSERT_EQ(out.size(), 5U);
  for (const plan::Unit& unit : out)
    lanes.consume(unit.replica.chain, unit.first_scan, results({.odds = 1.1}, unit));
  EXPECT_TRUE(lanes.finished());
  EXPECT_EQ(lanes.starts(), 5U);
  EXPECT_FALSE(lanes.next_unit(1).has_value());
}

TEST(SearchLanes, GivesUpWhenNothingIsFound) {
  // Goal: a search gives up after k_starts_in_vain_max failed starts in a row, and not before.
  // Method: test two searches. In one search, no start succeeds; in the other search, only the last
  // lane's start succeeds.
  random::Stream stream({.seed = 1, .purpose = random::Purpose::scene}, 0);
  SearchLanes lanes(1, 5);
  work(lanes, {.odds = 0}, 3, stream);
  EXPECT_TRUE(lanes.finished() && lanes.finds().gave_up);
  EXPECT_EQ(lanes.finds().found, 0U);
  EXPECT_GE(lanes.starts(), k_starts_in_vain_max);

  SearchLanes late(1, 1);
  std::vector<plan::ScanRecord> nothing(1);
  std::vector<plan::ScanRecord> find(1);
  find[0].satisfied = true;
  for (std::uint32_t lane = 0; lane < plan::k_search_lanes; ++lane) {
    EXPECT_FALSE(late.finished());
    late.consume(base::ChainId{plan::k_first_lane + lane}, {},
                 lane + 1 == plan::k_search_lanes ? find : nothing);
  }
  EXPECT_EQ(late.finds().found, 1U);
  EXPECT_FALSE(late.finds().gave_up);
}

TEST(SearchLanes, SayWhatTheStartsReached) {
  // Goal: a search that gives up tells which stage no start since the last find passed, which share
  // of these starts passed the earlier stages, and the nearest miss of the best starts. Method: let
  // start 20 succeed. Every 7th start is a best one, and misses by its number; of the others, odd
  // ones pass at most one stage. Lanes end in reverse order.
  const auto because = [](std::uint32_t furthest_before_find, std::uint32_t furthest_after) {
    SearchLanes lanes(1, 5,
                      {.stages = {"ball 1", "ball 2", "ball 3"},
                       .misses = {{"the hole", "mm"}},
                       .advice = "Look."});
    for (std::uint64_t scan = 0; !lanes.finished(); ++scan) {
      for (std::uint32_t lane = plan::k_search_lanes; lane-- > 0;) {
        std::vector<plan::ScanRecord> start(1);
        const std::uint64_t number = scan * plan::k_search_lanes + lane;
        start[0].satisfied = number == 20;
        const double furthest = number < 20 ? furthest_before_find : furthest_after;
        std::vector<double>& values = start[0].method_values;
        values = {number % 7 == 0 ? furthest : std::min(furthest, number % 2 == 0 ? 0.0 : 1.0)};
        if (number % 7 == 0 && furthest < 3)
          values.insert(values.end(), {0, static_cast<double>(number)});
        if (number == 20) values.clear();
        lanes.consume(base::ChainId{plan::k_first_lane + lane}, base::ScanIndex{scan}, start);
      }
    }
    EXPECT_TRUE(lanes.finds().gave_up);
    return lanes.finds().gave_up_because;
  };
  using testing::HasSubstr, testing::Not;
  EXPECT_THAT(because(0, 0), AllOf(HasSubstr("64 tries got past ball 1."), Not(HasSubstr("%"))));
  EXPECT_THAT(because(0, 0), AllOf(HasSubstr("missed the hole by 21 mm. Look.")));
  EXPECT_THAT(because(3, 1), AllOf(HasSubstr("got past ball 2. 58% got past ball 1. ")));
  EXPECT_THAT(because(1, 2), AllOf(HasSubstr("got past ball 3. 58% got past ball 1, 16% got past "
                                             "ball 2. The nearest missed the hole by 21 mm.")));
  EXPECT_THAT(because(1, 3),
              AllOf(HasSubstr("58% got past ball 1, 16% got past ball 3."), Not(HasSubstr("mm"))));
}

class ThreeScans final : public plan::Plan {
 public:
  std::optional<plan::Unit> next_unit(std::uint32_t) override {
    if (handed_out_ == 3) return std::nullopt;
    const base::ScanIndex scan{handed_out_++};
    return plan::Unit{.replica = {}, .first_scan = scan, .scans = 1, .starts = scan.value == 0};
  }
  void consume(plan::ReplicaKey, base::ScanIndex, std::span<const plan::ScanRecord>) override {
    ++consumed_;
  }
  bool finished() const override { return consumed_ == 3; }
  std::uint64_t scans_common() const override { return consumed_; }
  std::uint64_t solutions_found() const override { return 2; }
  std::vector<plan::Solution> solutions_between(std::uint64_t, std::uint64_t) const override {
    return {};
  }
  std::optional<std::uint64_t> solutions_wanted() const override { return 7; }
  std::uint64_t scans_consumed() const override { return consumed_; }
  std::optional<std::uint64_t> scans_total() const override { return 3; }

 private:
  std::uint64_t handed_out_ = 0;
  std::uint64_t consumed_ = 0;
};

TEST(SearchFirst, SearchesAndThenGoesOn) {
  // Goal: the search runs first, and then the plan runs unchanged. The search and the plan each
  // receive their own results. Method: run a search for two finds, and then a chain of three scans.
  SearchFirst plan(SearchLanes(1, 2), std::make_unique<ThreeScans>());
  std::vector<bool> searched;
  while (const auto unit = plan.next_unit(1)) {
    searched.push_back(unit->searches());
    EXPECT_FALSE(plan.finished());
    std::vector<plan::ScanRecord> records(1);
    records[0].satisfied = true;
    plan.consume(unit->replica, unit->first_scan, records);
  }
  EXPECT_EQ(searched, (std::vector<bool>{true, true, false, false, false}));
  EXPECT_TRUE(plan.finished());
  EXPECT_EQ(plan.finds().found, 2U);
  EXPECT_FALSE(plan.finds().is_all);
  EXPECT_EQ(plan.scans_common(), 3U);
  EXPECT_EQ(plan.scans_consumed(), 5U);
  EXPECT_EQ(plan.scans_total(), 5U);
  EXPECT_EQ(plan.solutions_found(), 2U);
  EXPECT_EQ(plan.solutions_wanted(), 7U);
}

TEST(SearchFirst, MayBeAll) {
  // Goal: a search can be a whole run, without a plan after it.
  SearchFirst plan(SearchLanes(1, 1), nullptr);
  EXPECT_TRUE(plan.finds().is_all);
  EXPECT_FALSE(plan.finished());
  EXPECT_EQ(plan.scans_total(), std::nullopt);
  std::vector<plan::ScanRecord> records(1);
  records[0].satisfied = true;
  const auto unit = plan.next_unit(1);
  plan.consume(unit->replica, unit->first_scan, records);
  EXPECT_TRUE(plan.finished());
  EXPECT_EQ(plan.scans_common(), 0U);
}

}  // namespace
}  // namespace sleight::sampling
