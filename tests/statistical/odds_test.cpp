// Goal: the interval in `sleight archive info` includes the truth as often as an interval of one
// standard error should. Ladders that have not mixed get no interval. Method: use worlds whose log
// Z and P are known. Run them as users do, and evaluate each run after each round. Compare trusted
// estimates with the truth, and show that doubted estimates are wrong more often.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "clients/analysis/odds_doubts.h"
#include "clients/analysis/throw_odds.h"
#include "tests/statistical/support/run_serially.h"
#include "tests/statistical/support/toy_worlds.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"

namespace sleight::statistical::odds_test {

constexpr std::uint64_t k_seed = 602214;

/// A world of letters in pairs. Each letter is right or wrong. If one letter of a pair is right,
/// p_c has a factor that acts as a barrier. A state satisfies the constraint if all letters are
/// right. A proposal changes at most one letter.
struct Letters {
  using State = std::uint32_t;
  using Outcome = std::uint32_t;
  std::uint32_t letters = 12;
  double right = 0.2;  ///< Prior probability that a letter is right.
  double log_lambda = 3;
  double log_half = 0;  ///< log p_c of a pair with one right letter.
  double busy = 1;      ///< Share of proposals that change a letter.

  State draw_prior(random::Stream& stream) const {
    State state = 0;
    for (std::uint32_t i = 0; i < letters; ++i)
      state |= State{stream.uniform() < right} << i;
    return state;
  }
  double log_prior(const State& state) const {
    const int count = std::popcount(state);
    return count * std::log(right) + (static_cast<int>(letters) - count) * std::log(1 - right);
  }
  Outcome simulate(const State& state) const { return state; }
  double log_constraint(const Outcome& outcome) const {
    const std::uint32_t half = (outcome ^ (outcome >> 1)) & 0x55555555U;
    return std::popcount(outcome) * log_lambda + std::popcount(half) * log_half;
  }
  bool satisfied(const Outcome& outcome) const { return outcome + 1 == 1U << letters; }
  std::uint32_t proposal_kinds() const { return 1; }
  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const {
    const bool changes = stream.uniform() < busy;
    const auto letter = static_cast<std::uint32_t>(stream.uniform() * letters);
    return {.candidate = changes ? state ^ (1U << letter) : state, .log_q_ratio = 0, .kind = 0};
  }
  std::size_t owned_bytes(const State&, const Outcome&) const { return 0; }
  base::Bytes encode(const State& state) const {
    base::ByteWriter writer;
    writer.put(state);
    return writer.take();
  }
  std::optional<State> decode(base::BytesView bytes) const {
    return base::ByteReader(bytes).get<State>();
  }
  std::vector<double> outcome_values(const Outcome& outcome) const {
    return {static_cast<double>(std::popcount(outcome))};
  }

  /// Product over independent pairs.
  double log_z() const {
    const double none = (1 - right) * (1 - right);
    const double one = 2 * right * (1 - right) * std::exp(log_lambda + log_half);
    const double both = right * right * std::exp(2 * log_lambda);
    return letters / 2 * std::log(none + one + both);
  }
  double log_p_satisfied() const { return letters * std::log(right); }
};
static_assert(run::World<Letters>);

/// Estimates of one quantity. Each ladder has an estimate in each round.
struct Series {
  std::vector<std::vector<analysis::LogEstimate>> rounds;  ///< By round, by ladder.
  double exact = 0;
};

struct Run {
  Series log_z;
  Series log_p;
  std::vector<std::vector<double>> round_trips;  ///< By round, by ladder.
};

template <class World>
Run run_ladders(const World& world, std::uint64_t seed, std::uint32_t ladders,
                std::uint32_t rounds) {
  const run::ChainWorker<World> worker(world, {.iterations_per_scan = 2});
  sampling::ParallelTempering plan(
      {.ladders = ladders,
       .ladder = {.seed = seed,
                  .chain = {},
                  .first_ladder = sampling::first_ladder(6),
                  .levels_chosen = true,
                  .levels_max = 64,
                  .ladder_adapts = true,
                  .has_scale = {false},
                  .round_scans = 32},
       .stop = {.scans = {}, .rounds = rounds, .independent_solutions = {}}});
  run_serially(plan, worker, {});
  Run run{.log_z = {.rounds = {}, .exact = world.log_z()},
          .log_p = {.rounds = {}, .exact = world.log_p_satisfied()},
          .round_trips = {}};
  for (std::uint32_t r = 0; r < rounds; ++r) {
    std::vector<analysis::LogEstimate>& log_z = run.log_z.rounds.emplace_back();
    std::vector<analysis::LogEstimate>& log_p = run.log_p.rounds.emplace_back();
    std::vector<double>& trips = run.round_trips.emplace_back();
    for (const sampling::LadderRun& ladder : plan.ladders()) {
      const sampling::RoundReport& round = ladder.rounds()[r];
      const sampling::Estimate z = round.statistics.log_z();
      const sampling::Estimate p = round.statistics.log_satisfied();
      log_z.push_back({z.value, z.error});
      log_p.push_back({p.value, p.error});
      trips.push_back(static_cast<double>(round.round_trips));
    }
  }
  return run;
}

struct Coverage {
  int judged = 0;
  int within_one = 0;
  int within_three = 0;
  double sum = 0;

  void add(const analysis::CombinedEstimate& estimate, double exact) {
    const double z = (estimate.log.value - exact) / estimate.log.error;
    ++judged;
    within_one += std::abs(z) <= 1 ? 1 : 0;
    within_three += std::abs(z) <= 3 ? 1 : 0;
    sum += z;
  }
  double share_within_one() const { return static_cast<double>(within_one) / judged; }
  double mean() const { return sum / judged; }
  double share_within_three() const { return static_cast<double>(within_three) / judged; }
};

struct Verdicts {
  Coverage trusted;
  Coverage doubted;  ///< Doubted estimates, with their errors anyway.
};

/// Judges a run as if it ended after each round. The first round never has an error and is omitted.
void judge(Verdicts& verdicts, const Run& run, const Series& series) {
  for (std::size_t r = 1; r < series.rounds.size(); ++r) {
    const analysis::LadderFacts facts{.judged = series.rounds[r],
                                      .before = series.rounds[r - 1],
                                      .round_trips = run.round_trips[r],
                                      .round = "the round"};
    const analysis::CombinedEstimate estimate = analysis::combined(facts.judged);
    if (analysis::doubts_of(facts).empty()) {
      verdicts.trusted.add(estimate, series.exact);
    } else if (std::isfinite(estimate.log.error)) {
      verdicts.doubted.add(estimate, series.exact);
    }
  }
}

void print(const char* what, const Coverage& coverage) {
  if (coverage.judged == 0) return;
  fmt::print("  {}: {} estimates, {:.3f} within one error, {:.3f} within three, mean z {:.2f}\n",
             what, coverage.judged, coverage.share_within_one(), coverage.share_within_three(),
             coverage.mean());
}

struct Ladders {
  std::uint32_t count = 4;
  int seeds = 16;
};

template <class World>
void add_world(Verdicts& all, const char* name, const World& world, const Ladders& ladders) {
  Verdicts of_world;
  for (int s = 0; s < ladders.seeds; ++s) {
    const std::uint64_t seed = k_seed + static_cast<std::uint64_t>(s);
    const Run run = run_ladders(world, seed, ladders.count, 7);
    for (const Series* series : {&run.log_z, &run.log_p}) {
      judge(of_world, run, *series);
      judge(all, run, *series);
    }
  }
  fmt::print("{}, {} ladders\n", name, ladders.count);
  print("trusted", of_world.trusted);
  print("doubted", of_world.doubted);
}

TEST(Odds, TrustedErrorsHoldTheTruth) {
  // Goal: the errors of trusted estimates are calibrated, and doubted estimates are worse. Method:
  // use three worlds: letters that change seldom, pairs of letters behind a barrier, and a bullseye
  // whose steps are too short. Run 1, 4 or 16 ladders for seven rounds. The first round has 32
  // scans, and each later round has twice as many as the round before. Ideally, 68% of trusted
  // estimates are within one error of the truth, and 99.7% within three. A round's log Z and log P
  // share most of their error, so only half of the estimates count as independent. The share within
  // one error may be up to five standard errors below 68%. The share within three errors must
  // exceed only 95%, because estimated errors have heavier tails. If 1% of estimates miss, seven or
  // more misses among 125 estimates occur once in 3,000 runs. Doubted estimates must miss more
  // often, and be too low on average.
  Letters seldom;
  seldom.busy = 0.1;
  Letters pairs;
  pairs.letters = 16;
  pairs.right = 0.1;
  pairs.log_half = -4;
  Bullseye narrow;
  narrow.target = 1.5;
  narrow.sigma = 0.05;
  narrow.tolerance = 0.06;
  narrow.step_sd = 0.02;
  Verdicts all;
  add_world(all, "letters that change seldom", seldom, {.count = 4, .seeds = 16});
  add_world(all, "letters in pairs", pairs, {.count = 4, .seeds = 16});
  add_world(all, "a bullseye and short steps", narrow, {.count = 4, .seeds = 16});
  add_world(all, "a bullseye and short steps", narrow, {.count = 1, .seeds = 48});
  add_world(all, "letters that change seldom", seldom, {.count = 16, .seeds = 3});
  fmt::print("all\n");
  print("trusted", all.trusted);
  print("doubted", all.doubted);
  ASSERT_GE(all.trusted.judged, 200) << "seed " << k_seed;
  const double error = std::sqrt(0.683 * 0.317 / (0.5 * all.trusted.judged));
  EXPECT_GT(all.trusted.share_within_one(), 0.683 - 5 * error) << "seed " << k_seed;
  EXPECT_GT(all.trusted.share_within_three(), 0.95) << "seed " << k_seed;
  EXPECT_LT(all.doubted.share_within_three(), 0.9) << "seed " << k_seed;
  EXPECT_LT(all.doubted.mean(), -0.5) << "seed " << k_seed;
}

TEST(Odds, LaddersThatNeverComeDownHaveNone) {
  // Goal: if 16 short ladders run for a hard word, their estimates are never trusted, even if the
  // ladders agree. Method: use letters that change so seldom that almost no ladder makes a round
  // trip.
  Letters stuck;
  stuck.letters = 20;
  stuck.busy = 0.01;
  Verdicts all;
  add_world(all, "letters that hardly change", stuck, {.count = 16, .seeds = 3});
  EXPECT_EQ(all.trusted.judged, 0) << "seed " << k_seed;
  EXPECT_LT(all.doubted.share_within_three(), 0.9) << "seed " << k_seed;
}

}  // namespace sleight::statistical::odds_test
