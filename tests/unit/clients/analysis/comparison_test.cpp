// Goal: `sleight compare` reports each key that differs between two requests, with both values.
#include "clients/analysis/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sleight::analysis {
namespace {

using testing::ElementsAre;

TEST(ComparedRequests, DifferByTheirKeys) {
  const std::string first =
      "# a comment\n[world]\nname = \"dice\"\n\n[[constraint.place]]\ndie = 1\nx_mm = 30\n\n"
      "[[constraint.place]]\ndie = 2\nx_mm = 5\n\n[stop]\nscans = 100\n";
  EXPECT_TRUE(other_lines(first, first).empty());
  std::string second = first;
  second.replace(second.find("x_mm = 5"), 8, "x_mm = 6");
  second.replace(second.find("scans = 100"), 11, "found = 3");
  const auto other = other_lines(first, second);
  std::vector<std::string> words;
  for (const OtherLine& line : other)
    words.push_back(line.key + "|" + line.first + "|" + line.second);
  EXPECT_THAT(words,
              ElementsAre("constraint.place[2].x_mm|5|6", "stop.scans|100|", "stop.found||3"));
}

}  // namespace
}  // namespace sleight::analysis
