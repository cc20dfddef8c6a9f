#include "worker/sampling/solutions.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

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
  // Goal: a lineage counts at the first scan at which it satisfies at inverse temperature 1, and
  // scans are in order whoever comes first. Method: by hand, lanes out of step.
  Solutions solutions;
  solutions.add(3, record_of(7, 1, false));
  solutions.add(4, record_of(7, 0.9, true));
  EXPECT_EQ(solutions.count(), 0U);
  solutions.add(20, record_of(9, 1, true));
  solutions.add(5, record_of(7, 1, true));
  solutions.add(6, record_of(7, 1, true));
  solutions.add(20, record_of(8, 1, true));
  EXPECT_EQ(solutions.scans(), (std::vector<std::uint64_t>{5, 20, 20}));
  EXPECT_EQ(solutions.count(), 3U);
  EXPECT_EQ(solutions.before(5), 0U);
  EXPECT_EQ(solutions.before(6), 1U);
  EXPECT_EQ(solutions.before(20), 1U);
  EXPECT_EQ(solutions.before(21), 3U);
}

}  // namespace
}  // namespace sleight::sampling
