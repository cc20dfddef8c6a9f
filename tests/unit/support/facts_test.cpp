// Goal: the matchers accept any sentence that has the given facts in the given order, and no other
// sentence. Method: use sentences in which a fact is missing, changed, out of order, or part of a
// longer number.
#include "tests/support/facts.h"

#include <gtest/gtest.h>

namespace sleight::tests {
namespace {

using ::testing::Not;

TEST(Facts, AreWholeWordsInOrder) {
  EXPECT_THAT("f:2: expected 0 to 2, found 2.1", HasFacts("f:2: |0|2|2.1"));
  EXPECT_THAT("f:2: 2.1 is outside of 0 to 2.", HasFacts("f:2: |2.1|0|2"));
  EXPECT_THAT("f:2: expected 0 to 2, found 2.1", Not(HasFacts("f:2: |2|0")));
  EXPECT_THAT("found 12, 2.1, 1.2, 2,000, 1,002 and x2", Not(HasFacts("2")));
  EXPECT_THAT("unknown keys", Not(HasFacts("key")));
  EXPECT_THAT("", Not(HasFacts("2")));
}

TEST(Facts, OfLinesAreForEachLine) {
  const std::string text = "f:1: no key 'a'\nf:2: no key 'b'\n";
  EXPECT_THAT(text, LinesHaveFacts("f:1: |'a'\nf:2: |'b'\n"));
  EXPECT_THAT(text, Not(LinesHaveFacts("f:1: |'a'")));
  EXPECT_THAT(text, Not(LinesHaveFacts("f:1: |'b'\nf:2: |'b'")));
  EXPECT_THAT(text, Not(LinesHaveFacts("'a'\n'b'")));
  EXPECT_THAT("", Not(LinesHaveFacts("f:1: ")));
}

}  // namespace
}  // namespace sleight::tests
