#include "worker/sampling/ladder_round.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "worker/sampling/ladder.h"

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_seed = 137036;

class Dice {
 public:
  explicit Dice(std::uint64_t index)
      : stream_({.seed = k_seed, .purpose = random::Purpose::prior}, index) {}
  std::uint64_t below(std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream_);
  }
  bool once_in(std::uint64_t count) { return below(count) == 0; }
  double uniform() { return stream_.uniform(); }

 private:
  random::Stream stream_;
};

LadderOptions random_options(Dice& dice) {
  return {
      .seed = 1,
      .chain = {},
      .first_ladder = first_ladder(static_cast<std::uint32_t>(2 + dice.below(9))),
      .levels_chosen = !dice.once_in(3),
      .levels_max = static_cast<std::uint32_t>(4 + dice.below(20)),
      .ladder_adapts = !dice.once_in(3),
      .has_scale = dice.once_in(3) ? std::vector<bool>{} : std::vector<bool>{true, dice.once_in(2)},
      .round_scans = 1 + dice.below(60),
      .anneal_scans = dice.once_in(2) ? 0 : dice.below(40)};
}

/// A round filled with random scans.
void fill(RoundReport& round, Dice& dice) {
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  const double roughness = dice.once_in(2) ? 1 : 40;
  for (std::uint64_t scan = 0; scan < round.statistics.scans_wanted(); ++scan) {
    std::vector<LevelScan> levels;
    for (KindCounts& counts : round.counts) {
      const double l = dice.once_in(20) ? -k_infinity : -roughness * dice.uniform();
      levels.push_back({.log_constraint = l, .satisfied = dice.once_in(4)});
      const auto accepted = static_cast<std::uint32_t>(dice.below(4));
      counts.add(std::vector<std::uint32_t>{3, 2},
                 std::vector<std::uint32_t>{accepted, accepted / 2});
    }
    round.statistics.add(levels);
  }
}

/// The learning once more, kind by kind and level by level.
struct Learnt {
  std::vector<double> ladder;
  std::vector<std::vector<double>> scales;
};
Learnt learnt_from(const LadderOptions& options, const RoundReport& last) {
  const std::vector<double>& old = last.statistics.ladder();
  const std::vector<double> rejections = last.statistics.rejections();
  std::size_t levels = old.size();
  double barrier = 0;
  for (const double rejection : rejections)
    barrier += rejection;
  if (options.levels_chosen) levels = std::min(levels_for(barrier), options.levels_max);
  const bool moves = options.ladder_adapts || levels != old.size();
  Learnt learnt;
  learnt.ladder = moves ? respaced(old, rejections, static_cast<std::uint32_t>(levels)) : old;
  learnt.scales.resize(levels);
  const bool any = std::ranges::count(options.has_scale, true) > 0;
  const std::size_t kinds = any ? last.counts[0].proposed.size() : 0;
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    std::vector<double> logs;
    for (std::size_t level = 0; level < old.size(); ++level)
      logs.push_back(
          math::log(tuned(last.scales[level], last.counts[level], options.has_scale)[kind]));
    logs[0] = logs[1];
    for (std::size_t level = 0; level < levels; ++level)
      learnt.scales[level].push_back(math::exp(interpolated(old, logs, learnt.ladder[level])));
  }
  return learnt;
}

TEST(LadderRound, LearnsWhatItsTwinSays) {
  // Goal: the next round's ladder and sizes follow from the last one's rejections and acceptances,
  // bit for bit. Method: 100 random courses of four rounds, against the same once more, plainly.
  std::size_t grew = 0;
  std::size_t shrank = 0;
  std::size_t scaled = 0;
  for (std::uint64_t index = 0; index < 100; ++index) {
    SCOPED_TRACE(fmt::format("seed {}, case {}", k_seed, index));
    Dice dice(index);
    const LadderOptions options = random_options(dice);
    RoundReport round = first_round(options);
    for (int nth = 0; nth < 4; ++nth) {
      fill(round, dice);
      const RoundReport next = next_round(options, round);
      const Learnt expected = learnt_from(options, round);
      ASSERT_EQ(next.ladder(), expected.ladder);
      ASSERT_EQ(next.scales, expected.scales);
      grew += next.ladder().size() > round.ladder().size() ? 1 : 0;
      shrank += next.ladder().size() < round.ladder().size() ? 1 : 0;
      scaled += next.scales[0].empty() || next.scales[0][0] == 1 ? 0 : 1;
      round = next;
    }
  }
  EXPECT_GT(grew, 20U);
  EXPECT_GT(shrank, 20U);
  EXPECT_GT(scaled, 20U);
}

TEST(LadderRound, FollowsTheLastAndIsTwiceAsLong) {
  // Goal: where rounds begin and end, and that a new one has nothing in it. Method: three rounds of
  // 5, 10 and 20 scans after 7 that anneal.
  Dice dice(0);
  LadderOptions options = random_options(dice);
  options.round_scans = 5;
  options.anneal_scans = 7;
  RoundReport round = first_round(options);
  EXPECT_EQ(round.ladder(), options.first_ladder);
  std::uint64_t begin = 7;
  for (const std::uint64_t length : {5U, 10U, 20U}) {
    EXPECT_EQ(round.first_scan, begin);
    EXPECT_EQ(round.end_scan(), begin + length);
    EXPECT_EQ(round.statistics.scans(), 0U);
    EXPECT_EQ(round.counts.size(), round.ladder().size());
    EXPECT_EQ(round.scales.size(), round.ladder().size());
    EXPECT_TRUE(round.counts.front().proposed.empty());
    EXPECT_EQ(round.round_trips + round.restarts, 0U);
    round.round_trips = round.restarts = 3;
    fill(round, dice);
    round = next_round(options, round);
    begin += length;
  }
}

}  // namespace
}  // namespace sleight::sampling
