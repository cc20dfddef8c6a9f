#include "worker/sampling/solutions.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "tests/unit/worker/sampling/scans_of.h"

namespace sleight::sampling {
namespace {

plan::ScanRecord record_of(std::uint64_t lineage, double beta, bool satisfied) {
  plan::ScanRecord record;
  record.lineage = lineage;
  record.inverse_temperature = beta;
  record.satisfied = satisfied;
  return record;
}

TEST(Solutions, CountEachLineageOnce) {
  // Goal: each lineage counts once, at its first satisfying scan at inverse temperature 1. The list
  // of counted scans is in ascending order, even if a later lineage is reported first.
  Solutions solutions;
  solutions.add(3, record_of(7, 1, false));
  solutions.add(4, record_of(7, 0.9, true));
  EXPECT_EQ(solutions.count(), 0U);
  solutions.add(20, record_of(9, 1, true));
  solutions.add(5, record_of(7, 1, true));
  solutions.add(6, record_of(7, 1, true));
  solutions.add(20, record_of(8, 1, true));
  EXPECT_EQ(scans_of(solutions), (std::vector<std::uint64_t>{5, 20, 20}));
  EXPECT_EQ(solutions.count(), 3U);
  EXPECT_EQ(solutions.before(5), 0U);
  EXPECT_EQ(solutions.before(6), 1U);
  EXPECT_EQ(solutions.before(20), 1U);
  EXPECT_EQ(solutions.before(21), 3U);
}

TEST(Solutions, OfChainsAreInOneOrder) {
  // Goal: solutions_between() orders the solutions of several chains by scan, chain and lineage.
  // The order of arrival doesn't matter. Method: use three chains. One chain has nothing to report
  // yet.
  Solutions early;
  Solutions late;
  plan::ScanRecord dense = record_of(3, 1, true);
  dense.log_prior = 2;
  dense.log_constraint = -0.5;
  late.add(20, record_of(9, 1, true));
  late.add(20, record_of(8, 1, true));
  late.add(4, dense);
  early.add(20, record_of(1, 1, true));
  const std::vector<const Solutions*> chains{nullptr, &late, &early};
  const auto told = solutions_between(chains, 4, 21);
  ASSERT_EQ(told.size(), 4U);
  EXPECT_EQ(told[0].chain, base::ChainId{1});
  EXPECT_EQ(told[0].scan, 4U);
  EXPECT_EQ(told[0].decided, 5U);
  EXPECT_EQ(told[0].log_p, 1.5);
  EXPECT_EQ(told[1].chain, base::ChainId{1});
  EXPECT_EQ(told[3].chain, base::ChainId{2});
  ASSERT_EQ(late.between(20, 21).size(), 2U);
  EXPECT_EQ(late.between(20, 21)[0].lineage, 8U);
  EXPECT_EQ(solutions_between(chains, 5, 20).size(), 0U);
  EXPECT_EQ(solutions_between(chains, 20, 21).size(), 3U);
}

}  // namespace
}  // namespace sleight::sampling
