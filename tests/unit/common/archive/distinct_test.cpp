// Goal: the selector keeps the animations that distinct.h defines. Method: compare the selector
// with a slow reference on random runs. The reference takes the draws in order of scan and chain,
// and applies the four conditions to each.
#include "common/archive/distinct.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/support/property.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::archive {
namespace {

using testing::FakeReader;
using testing::FakeRun;
using testing::FakeRunOptions;
using testing::mixed;

using Address = std::pair<std::uint64_t, std::uint32_t>;

std::vector<Address> reference(const FakeRun& run, const FakeReader& reader,
                               const DistinctOptions& options) {
  std::vector<Address> kept;
  std::map<std::pair<std::uint32_t, std::uint64_t>, std::vector<base::Bytes>> of_lineage;
  for (std::uint64_t scan = 0; scan < run.draws(); ++scan) {
    for (std::uint32_t chain = 0; chain < run.chains(); ++chain) {
      const plan::ScanRecord record = run.record({chain}, scan);
      auto& others = of_lineage[{chain, record.lineage}];
      bool keep = record.satisfied && others.size() < options.keep_per_lineage &&
                  kept.size() < options.keep_max;
      for (const base::Bytes& other : others) {
        keep = keep &&
               reader.likeness_distance(reader.likeness(other), reader.likeness(record.state)) >
                   options.min_distance;
      }
      if (!keep) continue;
      others.push_back(record.state);
      kept.push_back({scan, chain});
    }
  }
  return kept;
}

std::vector<Address> selected(const FakeRun& run, const FakeReader& reader,
                              const DistinctOptions& options) {
  DistinctSelector selector(reader, options);
  for (std::uint32_t chain = 0; chain < run.chains(); ++chain) {
    run.for_each_draw({chain}, [&](base::ScanIndex scan, const plan::ScanRecord& record) {
      selector.offer({chain}, scan, record);
    });
  }
  std::vector<Address> kept;
  for (const KeptAnimation& animation : selector.finish()) {
    EXPECT_EQ(animation.record, run.record(animation.chain, animation.scan.value));
    kept.push_back({animation.scan.value, animation.chain.value});
  }
  return kept;
}

TEST(Distinct, EqualsTheDefinitionOnRandomRuns) {
  const FakeReader reader;
  const std::uint64_t runs = property::of_tier(300, 2000);
  std::size_t truncated = 0;
  for (const std::uint64_t seed : property::cases(runs)) {
    const auto draw = [seed](std::uint64_t what, std::uint64_t below) {
      return mixed(seed * 16 + what) % below;
    };
    const FakeRun run({.seed = seed,
                       .chains = static_cast<std::uint32_t>(1 + draw(0, 5)),
                       .scans = 1 + draw(1, 60),
                       .thin = 1 + draw(2, 9),
                       .satisfied_share = testing::unit_of(seed * 16 + 3),
                       .lineages = 1 + draw(4, 12)});
    const DistinctOptions options{
        .keep_max = draw(5, 40),
        .keep_per_lineage = draw(6, 5),
        .min_distance = draw(7, 3) == 0 ? 0 : 0.1 * testing::unit_of(seed)};
    const auto expected = reference(run, reader, options);
    truncated += expected.size() == options.keep_max;
    ASSERT_EQ(selected(run, reader, options), expected) << "seed " << seed;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(truncated, runs / 20) << "the runs hardly ever meet keep_max";
}

/// Returns a draw that satisfies the constraint, in the state of `key`.
plan::ScanRecord satisfied(std::uint64_t key) {
  return {.satisfied = true,
          .lineage = 4,
          .proposed = {},
          .accepted = {},
          .outcome = {},
          .state = FakeReader::state_of(key)};
}

class CountedLikenesses final : public FakeReader {
 public:
  std::vector<double> likeness(base::BytesView state) const override {
    ++asked_[base::Bytes(state.begin(), state.end())];
    return FakeReader::likeness(state);
  }
  const std::map<base::Bytes, int>& asked() const { return asked_; }

 private:
  mutable std::map<base::Bytes, int> asked_;
};

TEST(Distinct, AsksOfEachAnimationOnceWhatIsCompared) {
  // Goal: the likeness of each animation is computed once. If there is too little memory, some
  // likenesses are computed again, but the same animations are kept. Method: offer a long lineage
  // of different states, first with memory for all likenesses, then with memory for five.
  constexpr std::uint64_t k_scans = 300;
  DistinctOptions options{.keep_max = 1000, .keep_per_lineage = 1000, .min_distance = 1e-3};
  const auto kept_by = [&](const StateReader& reader) {
    DistinctSelector selector(reader, options);
    for (std::uint64_t scan = 0; scan < k_scans; ++scan)
      selector.offer({0}, {scan}, satisfied(scan));
    std::vector<std::uint64_t> scans;
    for (const KeptAnimation& kept : selector.finish())
      scans.push_back(kept.scan.value);
    return scans;
  };
  const CountedLikenesses once;
  const std::vector<std::uint64_t> kept = kept_by(once);
  EXPECT_GT(kept.size(), 200U);
  EXPECT_LT(kept.size(), k_scans);
  EXPECT_EQ(once.asked().size(), k_scans);
  for (const auto& [state, times] : once.asked())
    EXPECT_EQ(times, 1);

  options.likeness_bytes_max = 5 * sizeof(double);
  const CountedLikenesses often;
  EXPECT_EQ(kept_by(often), kept);
  int most = 0;
  for (const auto& [state, times] : often.asked())
    most = std::max(most, times);
  EXPECT_GT(most, 100);
}

TEST(Distinct, AsksNothingOfThoseThatStayAlone) {
  // Goal: if only one animation per lineage is kept, no likeness is computed.
  const FakeRun run({.chains = 2, .scans = 300, .thin = 1, .satisfied_share = 0.8, .lineages = 5});
  const CountedLikenesses reader;
  EXPECT_EQ(selected(run, reader, {.keep_max = 1000, .keep_per_lineage = 1}).size(), 10U);
  EXPECT_TRUE(reader.asked().empty());
}

TEST(Distinct, EqualStatesAreKeptOnceWhenTheDistanceIsZero) {
  const FakeReader reader;
  DistinctSelector selector(reader, {.keep_max = 10, .keep_per_lineage = 3, .min_distance = 0});
  const plan::ScanRecord record = satisfied(9);
  for (std::uint64_t scan = 0; scan < 5; ++scan)
    selector.offer({0}, {scan}, record);
  selector.offer({1}, {2}, record);  // lineage numbers are per chain
  const std::vector<KeptAnimation> kept = selector.finish();
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].scan.value, 0U);
  EXPECT_EQ(kept[1].chain.value, 1U);
}

}  // namespace
}  // namespace sleight::archive
