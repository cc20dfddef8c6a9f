// The numbered events of a run are a function of its results.
#include "service/coordinator/event_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "tests/support/property.h"
#include "worker/sampling/independent_chains.h"
#include "worker/sampling/search_first.h"

namespace sleight::coordinator::event_sequence_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint64_t k_seed = 40517;

class Dice {
 public:
  explicit Dice(std::uint64_t index)
      : stream_({.seed = k_seed, .purpose = random::Purpose::prior}, index) {}
  std::uint64_t below(std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream_);
  }
  bool once_in(std::uint64_t count) { return below(count) == 0; }

 private:
  random::Stream stream_;
};

/// A run's results. Each result depends only on its chain and scan.
struct World {
  std::uint64_t seed = 1;
  std::uint64_t failing = 12;  ///< one scan in this many fails, some scans twice

  plan::ScanRecord record(std::uint32_t chain, std::uint64_t scan) const {
    random::Stream stream(
        {.seed = seed, .chain = base::ChainId{chain}, .purpose = random::Purpose::proposal}, scan);
    plan::ScanRecord record;
    record.log_prior = -stream.uniform();
    record.log_constraint = -stream.uniform();
    record.satisfied = stream.uniform() < 0.4;
    record.lineage = plan::lineage_from({}, scan - scan % 5);
    if (random::UniformInteger{.count = failing}.draw(stream) == 0) {
      record.failures.add(plan::FailureKind::work_limit);
      if (stream.uniform() < 0.3) record.failures.add(plan::FailureKind::scene_refused);
      if (stream.uniform() < 0.3) record.failures.add(plan::FailureKind::work_limit);
    }
    return record;
  }
};

/// The request of a run.
struct Asked {
  std::uint64_t scans = 60;
  std::uint64_t finds = 4;
};

std::unique_ptr<plan::Plan> plan_of(const Asked& asked) {
  return std::make_unique<sampling::SearchFirst>(
      sampling::SearchLanes(1, asked.finds),
      std::make_unique<sampling::IndependentChains>(sampling::IndependentChainsOptions{
          .seed = 1,
          .chains = 3,
          .round_scans = 7,
          .stop = {.scans = asked.scans, .rounds = {}, .independent_solutions = {}}}));
}

/// Numbers events in their order of arrival. The checks below must detect this mistake.
class CompletionOrder {
 public:
  explicit CompletionOrder(const store::ToldFrontier& told) : told_(told) {}
  void consumed(const plan::ReplicaKey& replica, base::ScanIndex first_scan,
                std::span<const plan::ScanRecord> records) {
    for (std::size_t nth = 0; nth < records.size(); ++nth) {
      if (!records[nth].satisfied) continue;
      found_.push_back({.what = events::Solution{.nth = ++told_.solutions,
                                                 .in_proportion = true,
                                                 .chain = replica.chain.value,
                                                 .scan = first_scan.value + nth}});
    }
  }
  std::vector<events::RunEvent> advance(const plan::Plan&) { return std::exchange(found_, {}); }
  const store::ToldFrontier& frontier() const { return told_; }

 private:
  store::ToldFrontier told_;
  std::vector<events::RunEvent> found_;
};

/// A run of several sessions with any number of workers. Results arrive in any order. If a session
/// dies, its earlier results and events remain.
class PlayedRun {
 public:
  explicit PlayedRun(const World& world) : world_(world) {}

  /// Runs until the run is done or `results_max` results have arrived.
  template <class Sequence = EventSequence>
  void session(const Asked& asked, Dice& dice, std::size_t workers,
               std::uint64_t results_max = UINT64_MAX) {
    const std::unique_ptr<plan::Plan> plan = plan_of(asked);
    Sequence sequence(told_);
    for (const auto& [replica, records] : stored_) {
      sequence.consumed(replica, base::ScanIndex{0}, records);
      plan->consume(replica, base::ScanIndex{0}, records);
    }
    tell(sequence, *plan);
    std::vector<plan::Unit> out;
    for (std::uint64_t came = 0; came < results_max; ++came) {
      while (out.size() < workers) {
        const auto unit = plan->next_unit(static_cast<std::uint32_t>(1 + dice.below(9)));
        if (!unit) break;
        out.push_back(*unit);
      }
      if (out.empty()) break;
      const auto which = static_cast<std::ptrdiff_t>(dice.below(out.size()));
      const plan::Unit unit = out[static_cast<std::size_t>(which)];
      out.erase(out.begin() + which);
      std::vector<plan::ScanRecord> records;
      for (std::uint64_t scan = unit.first_scan.value; records.size() < unit.scans; ++scan)
        records.push_back(world_.record(unit.replica.chain.value, scan));
      sequence.consumed(unit.replica, unit.first_scan, records);
      plan->consume(unit.replica, unit.first_scan, records);
      std::ranges::copy(records, std::back_inserter(stored_[unit.replica]));
      if (dice.once_in(1 + workers)) tell(sequence, *plan);
    }
    // A session that dies may have stored results without their events.
    if (results_max == UINT64_MAX) tell(sequence, *plan);
  }

  const std::vector<std::string>& lines() const { return lines_; }
  std::uint64_t count(std::string_view what) const {
    return static_cast<std::uint64_t>(std::ranges::count_if(
        lines_, [&](const std::string& line) { return line.find(what) != std::string::npos; }));
  }

 private:
  template <class Sequence>
  void tell(Sequence& sequence, const plan::Plan& plan) {
    const std::vector<events::RunEvent> events = sequence.advance(plan);
    for (const events::RunEvent& event : events)
      lines_.push_back(events::to_line(event));
    if (!events.empty()) told_ = sequence.frontier();
  }

  World world_;
  std::map<plan::ReplicaKey, std::vector<plan::ScanRecord>> stored_;
  std::vector<std::string> lines_;
  store::ToldFrontier told_;
};

/// Returns a run of one session. The only worker reports results one by one.
PlayedRun quiet_run(const World& world, const Asked& asked) {
  Dice dice(0);
  PlayedRun run(world);
  run.session(asked, dice, 1);
  return run;
}

TEST(EventSequence, IsTheSameHoweverResultsCome) {
  // Goal: a run's events and their order don't depend on the number of workers, the order of
  // results or the number of calls (invariant 1). Sessions that die don't change the events.
  // Method: make random runs that consist of a search and then chains. Their sessions die at
  // random. Compare each run's events with the events of an undisturbed run.
  std::uint64_t failures = 0;
  for (const std::uint64_t index : property::cases(150)) {
    Dice dice(index);
    const World world{.seed = index};
    const Asked asked{.scans = 20 + dice.below(80), .finds = dice.below(6)};
    const PlayedRun quiet = quiet_run(world, asked);
    EXPECT_EQ(quiet.count("\"in_proportion\":false"), asked.finds);
    EXPECT_GE(quiet.count("\"in_proportion\":true"), 3U);
    EXPECT_GE(quiet.count("round_ended"), 1U);
    failures += quiet.count("\"failure\"");

    PlayedRun run(world);
    for (std::uint64_t deaths = dice.below(4); deaths > 0; --deaths)
      run.session(asked, dice, 1 + dice.below(6), dice.below(25));
    run.session(asked, dice, 1 + dice.below(6));
    EXPECT_EQ(run.lines(), quiet.lines());
  }
  if (property::all_cases()) {
    EXPECT_GT(failures, 1000U);
  }
}

TEST(EventSequence, NumberedInCompletionOrderItWouldBeCaught) {
  // Goal: the test above would fail if events were numbered in their order of arrival.
  std::uint64_t caught = 0;
  for (std::uint64_t index = 0; index < 40; ++index) {
    Dice dice(index);
    const World world{.seed = index};
    PlayedRun quiet(world);
    quiet.session<CompletionOrder>({}, dice, 1);
    PlayedRun run(world);
    run.session<CompletionOrder>({}, dice, 4);
    caught += run.lines() == quiet.lines() ? 0 : 1;
  }
  EXPECT_GT(caught, 35U);
}

TEST(EventSequence, OfALongerStopGoesOn) {
  // Goal: if a run is extended to more scans, it reports the events of one long run (invariant 2).
  // If fewer scans are requested in between, no event is added. If more finds are requested, only
  // the events of these finds are added. Method: extend random runs step by step.
  for (const std::uint64_t index : property::cases(60)) {
    Dice dice(index);
    const World world{.seed = index};
    const Asked asked{.scans = 30 + dice.below(30), .finds = 3};
    const Asked more{.scans = asked.scans + dice.below(40), .finds = 3};
    PlayedRun run(world);
    run.session(asked, dice, 3);
    const std::vector<std::string> before = run.lines();
    EXPECT_EQ(before, quiet_run(world, asked).lines());
    run.session({.scans = asked.scans / 2, .finds = 2}, dice, 3);
    EXPECT_EQ(run.lines(), before);
    run.session(more, dice, 3);
    const PlayedRun at_once = quiet_run(world, more);
    EXPECT_EQ(run.lines(), at_once.lines());

    run.session({.scans = more.scans, .finds = 6}, dice, 3);
    EXPECT_TRUE(
        std::ranges::equal(at_once.lines(), std::span(run.lines()).first(at_once.lines().size())));
    const PlayedRun searched = quiet_run(world, {.scans = more.scans, .finds = 6});
    EXPECT_TRUE(std::ranges::is_permutation(run.lines(), searched.lines()));
  }
}

TEST(EventSequence, TellsInTheOrderOfItsHeader) {
  // Goal: events have the order that event_sequence.h defines, and the right places, numbers and
  // files. Method: construct results of two chains. Consume the second chain's results first. The
  // failures of both chains must come first, then the solutions, then the round.
  sampling::IndependentChains plan(
      {.seed = 1,
       .chains = 2,
       .round_scans = 2,
       .stop = {.scans = 9, .rounds = {}, .independent_solutions = {}}});
  EventSequence sequence(
      {.scans = 0, .solutions = 7, .failures = 3},
      [](const plan::ReplicaKey& replica, base::ScanIndex scan, plan::FailureKind kind) {
        return std::to_string(replica.chain.value) + "/" + std::to_string(scan.value) + "/" +
               std::string(name_of(kind));
      });
  std::vector<plan::ScanRecord> records(3);
  records[1].failures.by_kind = {0, 2, 0, 0, 0, 1};
  records[1].satisfied = true;
  records[1].log_prior = -1.5;
  records[1].log_constraint = -0.25;
  records[1].lineage = 4;
  records[2].failures.add(plan::FailureKind::work_limit);
  const auto take = [&](std::uint32_t chain, std::size_t count) {
    (void)plan.next_unit(3);
    const plan::ReplicaKey replica{base::ChainId{chain}, base::ReplicaId{0}};
    sequence.consumed(replica, base::ScanIndex{0}, std::span(records).first(count));
    plan.consume(replica, base::ScanIndex{0}, std::span(records).first(count));
    return sequence.advance(plan);
  };
  (void)plan.next_unit(3);
  EXPECT_THAT(take(1, 3), IsEmpty());
  const std::vector<events::RunEvent> told = take(0, 2);
  ASSERT_THAT(told, SizeIs(7));
  const auto failure = [&](std::size_t nth) { return std::get<events::Failure>(told[nth].what); };
  const auto expected = [](std::uint32_t chain, const std::string& kind) {
    return events::Failure{.simulation = kind,
                           .chain = chain,
                           .replica = 0,
                           .scan = 1,
                           .file = std::to_string(chain) + "/1/" + kind};
  };
  EXPECT_EQ(failure(0), expected(0, "too_many_collisions"));
  EXPECT_EQ(failure(1), expected(0, "scene_refused"));
  EXPECT_EQ(failure(2), expected(1, "too_many_collisions"));
  EXPECT_EQ(failure(3), expected(1, "scene_refused"));
  for (const std::uint32_t chain : {0U, 1U}) {
    EXPECT_EQ(
        std::get<events::Solution>(told[4 + chain].what),
        (events::Solution{
            .nth = 8 + chain, .in_proportion = true, .chain = chain, .scan = 1, .log_p = -1.75}));
  }
  EXPECT_EQ(std::get<events::RoundEnded>(told[6].what),
            (events::RoundEnded{.chain = 0, .round = 1, .scans = 2}));
  EXPECT_EQ(sequence.frontier(), (store::ToldFrontier{.scans = 2, .solutions = 9, .failures = 7}));
}

TEST(EventSequence, TellsSoManyFailuresAndNoMore) {
  // Goal: if every simulation fails, a run reports the same first failures in any order of results.
  // All sessions together report at most as many as the limit.
  const World world{.seed = 5, .failing = 1};
  const Asked asked{.scans = 500, .finds = 0};
  const PlayedRun quiet = quiet_run(world, asked);
  EXPECT_EQ(quiet.count("\"failure\""), k_failures_told_max);
  for (const std::uint64_t index : property::cases(5)) {
    Dice dice(index);
    PlayedRun run(world);
    run.session(asked, dice, 5, 100);
    run.session(asked, dice, 4);
    EXPECT_EQ(run.lines(), quiet.lines());
  }
}

}  // namespace sleight::coordinator::event_sequence_test
