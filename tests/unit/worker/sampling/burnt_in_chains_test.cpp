// Tests properties of every sampling method. For example, results don't depend on blocks,
// interruptions or the order in which they arrive. Also tests stop rules, draws, burn-in and
// simulated annealing.
#include "worker/sampling/burnt_in_chains.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "tests/support/property.h"
#include "tests/unit/worker/sampling/any_plan.h"
#include "worker/sampling/annealed_importance.h"
#include "worker/sampling/excursions.h"
#include "worker/sampling/independent_chains.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"
#include "worker/sampling/simulated_tempering.h"

namespace sleight::sampling::burnt_in_chains_test {

constexpr std::uint64_t k_seed = 208109;
constexpr std::uint64_t k_cases = 80;
constexpr std::uint64_t k_scans_max = 320;

std::uint64_t cases() {
  return property::of_tier(30, k_cases);
}

enum class Method : std::uint8_t { plain, parallel, simulated, transitions, importance };
constexpr std::uint64_t k_methods = 5;

struct Case {
  Method method = Method::plain;
  std::uint32_t chains = 1;
  LadderOptions ladder;
  std::uint32_t burn_in_rounds = 1;
  std::uint32_t steps = 1;
  std::uint32_t lanes = 1;
  StopRule stop;
  HashedWorker::Options worker;

  bool burns_in() const { return method != Method::plain && method != Method::parallel; }
  /// Scans before the rounds of the stop rule.
  std::uint64_t before() const {
    return ladder.anneal_scans +
           (burns_in() ? scans_through_round(ladder.round_scans, burn_in_rounds) : 0);
  }
};

Case random_case(Dice& dice, std::uint64_t index) {
  Case made;
  made.method = static_cast<Method>(index % k_methods);
  made.chains = static_cast<std::uint32_t>(1 + dice.below(3));
  made.worker = {.seed = dice.below(1000),
                 .roughness = {0.1, 2, 12, 60},
                 .broken = dice.once_in(2) ? 0 : 0.2,
                 .satisfied = dice.once_in(2) ? 0.02 : 0.3};
  made.ladder = {
      .seed = made.worker.seed,
      .chain = {},
      .first_ladder = first_ladder(static_cast<std::uint32_t>(2 + dice.below(6))),
      .levels_chosen = !dice.once_in(3),
      .levels_max = static_cast<std::uint32_t>(4 + dice.below(12)),
      .ladder_adapts = true,
      .has_scale = dice.once_in(3) ? std::vector<bool>{} : std::vector<bool>{true, dice.once_in(2)},
      .round_scans = 1 + dice.below(25),
      .anneal_scans = dice.once_in(2) ? 0 : 1 + dice.below(30)};
  made.burn_in_rounds = static_cast<std::uint32_t>(1 + dice.below(3));
  made.steps = static_cast<std::uint32_t>(1 + dice.below(4));
  made.lanes = static_cast<std::uint32_t>(1 + dice.below(4));
  if (dice.once_in(2)) made.stop.independent_solutions = 1 + dice.below(40);
  if (dice.once_in(2)) made.stop.rounds = static_cast<std::uint32_t>(1 + dice.below(3));
  if (dice.once_in(2) || !made.stop.rounds) made.stop.scans = 1 + dice.below(k_scans_max);
  return made;
}

/// Lets some ladders of parallel tempering start from searches. These ladders must forget the
/// searches' finds.
Case from_searches(Case given, Dice& dice) {
  if (given.method != Method::parallel || !dice.once_in(2)) return given;
  given.ladder.starts_by_search = true;
  given.ladder.anneal_scans = 0;
  return given;
}

std::unique_ptr<ChainPart> part_of(const Case& given, const BurnIn& burn_in) {
  switch (given.method) {
    case Method::simulated:
      return std::make_unique<SimulatedTempering>(burn_in);
    case Method::transitions:
      return std::make_unique<Excursions>(burn_in, given.steps);
    default:
      return std::make_unique<AnnealedImportance>(burn_in, given.lanes, given.steps);
  }
}

std::unique_ptr<plan::Plan> plan_of(const Case& given, const StopRule& stop) {
  if (given.method == Method::plain) {
    return std::make_unique<IndependentChains>(
        IndependentChainsOptions{.seed = given.ladder.seed,
                                 .chains = given.chains,
                                 .round_scans = given.ladder.round_scans,
                                 .anneal_scans = given.ladder.anneal_scans,
                                 .stop = stop});
  }
  if (given.method == Method::parallel) {
    return std::make_unique<ParallelTempering>(
        ParallelTemperingOptions{.ladders = given.chains, .ladder = given.ladder, .stop = stop});
  }
  return std::make_unique<BurntInChains>(
      BurntInOptions{.chains = given.chains,
                     .ladder = given.ladder,
                     .burn_in_rounds = given.burn_in_rounds,
                     .stop = stop,
                     .go_on = [given](const BurnIn& found) { return part_of(given, found); }});
}

StopRule after(std::uint64_t scans) {
  return {.scans = scans, .rounds = {}, .independent_solutions = {}};
}

/// The smallest number of draws of a chain. A draw is a record at inverse temperature 1 after the
/// burn-in.
std::uint64_t draws_of(const Case& given, const ScanRuns& runs) {
  std::vector<std::uint64_t> draws(given.chains, 0);
  for (const auto& [place, run] : runs) {
    if (run.record.inverse_temperature == 1 && place.scan >= given.before())
      ++draws[place.replica.chain.value];
  }
  return std::ranges::min(draws);
}

void expect_same_moment(const plan::Plan& a, const plan::Plan& b) {
  EXPECT_EQ(a.finished(), b.finished());
  EXPECT_EQ(a.scans_common(), b.scans_common());
  EXPECT_EQ(a.draws().first_scan, b.draws().first_scan);
  EXPECT_EQ(a.draws().count, b.draws().count);
  EXPECT_EQ(a.solutions_found(), b.solutions_found());
  EXPECT_EQ(a.scans_consumed(), b.scans_consumed());
  EXPECT_EQ(a.scans_total(), b.scans_total());
  expect_equal(a.report(), b.report());
}

struct Decided {
  std::uint64_t scans = 0;
  std::vector<plan::Solution> solutions{};
  std::vector<plan::EndedRound> rounds{};

  void move_to(const plan::Plan& plan) {
    const std::uint64_t until = plan.scans_common();
    std::ranges::copy(plan.solutions_between(scans, until), std::back_inserter(solutions));
    std::ranges::copy(plan.rounds_between(scans, until), std::back_inserter(rounds));
    scans = until;
  }
  void expect_equal_to(const Decided& other) const {
    const auto solution = [](const plan::Solution& one) {
      return std::tuple(one.decided, one.chain, one.scan, one.log_p);
    };
    const auto round = [](const plan::EndedRound& one) {
      return std::tuple(one.scans, one.chain, one.round, one.swaps, one.round_trips);
    };
    EXPECT_TRUE(std::ranges::equal(solutions, other.solutions, {}, solution, solution));
    EXPECT_TRUE(std::ranges::equal(rounds, other.rounds, {}, round, round));
    EXPECT_TRUE(std::ranges::is_sorted(rounds, {}, round));
  }
};

TEST(EveryMethod, DoesNotKnowTheOrderOfDelivery) {
  // Goal: units, results, the stop, draws and the report don't depend on how a run is cut into
  // units and blocks. The order in which units and blocks complete has no effect, either. The run
  // stops where its rules say. Method: compare random sessions with a serial run. Some sessions run
  // units, and some run blocks. Recompute the stop and the draws from a longer run. Pairs of a
  // method and whether its run ended before the limit on scans.
  std::set<std::pair<std::uint64_t, bool>> stops;
  std::vector<BlockShapes> shapes(k_methods);
  for (const std::uint64_t index : property::cases(cases())) {
    Dice dice(k_seed, index);
    const Case given = random_case(dice, index);
    const ScanByScan worker(given.worker);
    const auto longer = plan_of(given, after(8 * k_scans_max));
    AnySession all(*longer, worker);
    all.run_serially();
    const std::uint64_t end =
        scans_at_stop(given.stop, given.ladder.round_scans, given.before(), all.runs());
    ASSERT_LE(end, 8 * k_scans_max);

    const auto serial_plan = plan_of(given, given.stop);
    AnySession serial(*serial_plan, worker);
    serial.run_serially();
    EXPECT_EQ(serial_plan->scans_common(), end);
    EXPECT_EQ(serial_plan->scans_consumed(), serial.runs().size());
    EXPECT_EQ(serial_plan->draws().first_scan, given.before());
    EXPECT_EQ(serial_plan->draws().count, draws_of(given, serial.runs()));
    EXPECT_EQ(serial_plan->next_unit(1), std::nullopt);
    for (const auto& [place, run] : serial.runs())
      ASSERT_EQ(run, all.runs().at(place));
    stops.emplace(index % k_methods, given.stop.scans != end);
    for (int repeat = 0; repeat < 6; ++repeat) {
      const auto plan = plan_of(given, given.stop);
      AnySession session(*plan, worker);
      if (repeat % 2 == 0) {
        session.run_randomly(dice);
      } else {
        session.run_in_blocks(dice, shapes[index % k_methods]);
      }
      expect_same_moment(*plan, *serial_plan);
      EXPECT_TRUE(session.runs() == serial.runs());
      if (HasFailure()) return;
    }
  }
  if (!property::all_cases() || cases() < k_cases) return;
  EXPECT_EQ(stops.size(), 2 * k_methods);
  for (std::uint64_t method = 0; method < k_methods; ++method) {
    SCOPED_TRACE(method);
    const bool meets = static_cast<Method>(method) != Method::plain;
    EXPECT_EQ(shapes[method].of_several > 500, meets);
    EXPECT_EQ(shapes[method].swapped > 500, meets);
    EXPECT_GT(shapes[method].annealing, 20U);
  }
}

TEST(EveryMethod, GoesOnFromAnyStoredResults) {
  // Goal: if a fresh plan consumes a stopped plan's stored results, the fresh plan equals the
  // stopped plan and reaches the same end. Method: stop a session at a random moment, and lose or
  // store the results in flight. Let a fresh plan consume the stored results in stored or random
  // order. Then continue in units or in blocks.
  BlockShapes shapes;
  for (const std::uint64_t index : property::cases(2 * cases())) {
    Dice dice(k_seed, k_cases + index);
    const Case given = from_searches(random_case(dice, index), dice);
    const ScanByScan worker(given.worker);
    const auto whole_plan = plan_of(given, given.stop);
    AnySession whole(*whole_plan, worker);
    whole.run_serially();
    const auto stopped_plan = plan_of(given, given.stop);
    AnySession stopped(*stopped_plan, worker);
    const auto run_some = [&](AnySession& session, std::uint64_t steps) {
      if (dice.once_in(2)) {
        session.run_randomly(dice, steps);
      } else {
        session.run_in_blocks(dice, shapes, steps);
      }
    };
    run_some(stopped, dice.below(3 * whole.runs().size()));
    if (dice.once_in(2)) stopped.complete_all(dice);
    const auto plan = plan_of(given, given.stop);
    AnySession resumed(*plan, worker);
    resumed.replay(stopped.runs(), dice);
    expect_same_moment(*plan, *stopped_plan);
    run_some(resumed, UINT64_MAX);
    expect_same_moment(*plan, *whole_plan);
    EXPECT_TRUE(resumed.runs() == whole.runs());
    if (HasFailure()) return;
  }
}

TEST(EveryMethod, DecidesTheSameInAnySteps) {
  // Goal: a plan can report solutions and rounds at any moments. The reports add up to the single
  // report of a run that reports only at its end. Each reported solution is a satisfying scan at
  // inverse temperature 1, and all counted solutions are reported. Method: request reports at
  // random moments of random sessions. Some sessions are stopped and resumed.
  std::set<Method> methods;
  for (const std::uint64_t index : property::cases(cases())) {
    Dice dice(k_seed, 5 * k_cases + index);
    const Case given = random_case(dice, index);
    const ScanByScan worker(given.worker);
    const auto quiet_plan = plan_of(given, given.stop);
    AnySession quiet(*quiet_plan, worker);
    quiet.run_serially();
    Decided whole;
    whole.move_to(*quiet_plan);
    for (const plan::Solution& solution : whole.solutions) {
      const auto is_it = [&](const auto& entry) {
        const plan::ScanRecord& record = entry.second.record;
        return entry.first.replica.chain == solution.chain && entry.first.scan == solution.scan &&
               record.satisfied && record.inverse_temperature == 1 &&
               record.log_prior + record.log_constraint == solution.log_p;
      };
      ASSERT_TRUE(std::ranges::any_of(quiet.runs(), is_it));
      EXPECT_LT(solution.scan, solution.decided);
    }
    if (quiet_plan->scans_consumed() == quiet_plan->scans_common() * given.chains) {
      EXPECT_EQ(whole.solutions.size(), quiet_plan->solutions_found());
    }
    if (!whole.solutions.empty() && !whole.rounds.empty()) methods.insert(given.method);

    Decided decided;
    auto plan = plan_of(given, given.stop);
    auto session = std::make_unique<AnySession>(*plan, worker);
    while (!plan->finished()) {
      session->run_randomly(dice, 1 + dice.below(60));
      if (dice.once_in(2)) decided.move_to(*plan);
      if (!dice.once_in(4)) continue;
      const ScanRuns stored = session->runs();
      plan = plan_of(given, given.stop);
      session = std::make_unique<AnySession>(*plan, worker);
      session->replay(stored, dice);
    }
    decided.move_to(*plan);
    decided.expect_equal_to(whole);
    if (HasFailure()) return;
  }
  if (property::all_cases() && cases() == k_cases) {
    EXPECT_EQ(methods.size(), k_methods);
  }
}

TEST(EveryMethod, CutAtAnyScanIsTheRunOfThatManyScans) {
  // Goal: if a plan consumes a longer run's stored scans below N, it equals a plan that runs N
  // scans. Method: cut whole runs at a random scan N, sometimes in the burn-in.
  for (const std::uint64_t index : property::cases(cases())) {
    Dice dice(k_seed, 3 * k_cases + index);
    const Case given = from_searches(random_case(dice, index), dice);
    const ScanByScan worker(given.worker);
    const auto whole_plan = plan_of(given, given.stop);
    AnySession whole(*whole_plan, worker);
    whole.run_serially();
    const std::uint64_t cut = 1 + dice.below(whole_plan->scans_common());
    ScanRuns kept;
    for (const auto& [place, run] : whole.runs()) {
      if (place.scan < cut) kept.emplace(place, run);
    }
    const auto learner_plan = plan_of(given, after(cut));
    AnySession learner(*learner_plan, worker);
    learner.replay(kept, dice);
    const auto direct_plan = plan_of(given, after(cut));
    AnySession direct(*direct_plan, worker);
    direct.run_serially();
    EXPECT_TRUE(learner_plan->finished());
    expect_same_moment(*learner_plan, *direct_plan);
    EXPECT_TRUE(direct.runs() == kept);
    if (HasFailure()) return;
  }
}

TEST(EveryMethod, KnowsHowMuchThereIsToDoAlsoWhileItAnneals) {
  // Goal: a plan with a fixed number of scans reports its total from the start. The total includes
  // annealing and never changes. At the end, the total equals the number of consumed scans. Method:
  // read the total at every step, for independent chains and for ladders of four fixed levels.
  for (const Method method : {Method::plain, Method::parallel}) {
    Dice dice(k_seed, 5 * k_cases);
    Case given = random_case(dice, 0);
    given.method = method;
    given.chains = 2;
    given.ladder.first_ladder = first_ladder(4);
    given.ladder.levels_chosen = false;
    given.ladder.anneal_scans = 12;
    const ScanByScan worker(given.worker);
    const auto plan = plan_of(given, after(50));
    AnySession session(*plan, worker);
    const std::uint64_t total = 2U * 50 * (method == Method::parallel ? 4 : 1);
    while (!plan->finished() && !HasFailure()) {
      ASSERT_EQ(plan->scans_total(), total);
      session.run_randomly(dice, 1);
    }
    EXPECT_EQ(plan->scans_consumed(), total);
    EXPECT_EQ(plan->scans_total(), total);
  }
}

TEST(BurntInChains, BurnInIsParallelTempering) {
  // Goal: a burn-in equals a run of parallel tempering with the same number of rounds. Method: run
  // both with the same options, and compare all scans and the reported tables of ladders.
  for (const std::uint64_t index : property::cases(20)) {
    Dice dice(k_seed, 6 * k_cases + index);
    Case given = random_case(dice, 2 + index % 3);
    const ScanByScan worker(given.worker);
    const auto plan = plan_of(given, after(given.before() + 40));
    AnySession session(*plan, worker);
    session.run_serially();
    given.method = Method::parallel;
    const std::uint64_t burn_in =
        given.before() + scans_through_round(given.ladder.round_scans, given.burn_in_rounds);
    const auto tempered_plan = plan_of(given, after(burn_in));
    AnySession tempered(*tempered_plan, worker);
    tempered.run_serially();
    for (const auto& [place, run] : tempered.runs())
      ASSERT_EQ(run, session.runs().at(place));
    for (const auto& [place, run] : session.runs())
      ASSERT_TRUE(place.scan >= burn_in || tempered.runs().contains(place));
    plan::Report tables = plan->report();
    tables.warning.clear();
    const plan::Report expected = tempered_plan->report();
    ASSERT_GT(tables.tables.size(), expected.tables.size());
    tables.tables.resize(expected.tables.size());
    expect_equal(tables, expected);
  }
}

TEST(Annealing, GoesFromThePriorInEqualSteps) {
  // Goal: in scan s of n, annealing uses s / n of a replica's final inverse temperature. For plain
  // chains, the final one is 1.
  for (const std::uint64_t index : property::cases(30)) {
    Dice dice(k_seed, 7 * k_cases + index);
    Case given = random_case(dice, index);
    given.ladder.anneal_scans = 1 + dice.below(30);
    const auto n = static_cast<double>(given.ladder.anneal_scans);
    const ScanByScan worker(given.worker);
    const auto plan = plan_of(given, after(given.ladder.anneal_scans + 1));
    AnySession session(*plan, worker);
    session.run_randomly(dice);
    for (const auto& [place, run] : session.runs()) {
      const double target = given.method == Method::plain
                                ? 1
                                : given.ladder.first_ladder[place.replica.replica.value];
      const double share = std::min(1.0, static_cast<double>(place.scan) / n);
      ASSERT_EQ(run.unit.inverse_temperature(0), target * share);
      ASSERT_EQ(run.unit.starts, place.scan == 0);
      ASSERT_TRUE(run.unit.proposal_scales.empty());
    }
  }
}

}  // namespace sleight::sampling::burnt_in_chains_test
