// Goal: while an archive is written slowly, messages report the rate and the remaining time.
#include "service/coordinator/writing_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/facts.h"

namespace sleight::coordinator {
namespace {

using Part = archive::WritingProgress::Part;

TEST(WritingWords, TellsWhatTakesItsTime) {
  base::ManualClock clock;
  std::vector<std::string> said;
  WritingWords words([&](const std::string& line) { said.push_back(line); }, clock);
  words.hear({.part = Part::learning, .done = 100});
  words.hear({.part = Part::draws, .done = 0, .total = 5000});
  clock.advance(0.4);
  words.hear({.part = Part::draws, .done = 900, .total = 5000});
  EXPECT_TRUE(said.empty()) << "what is over at once is not told";
  clock.advance(0.6);
  words.hear({.part = Part::draws, .done = 1250, .total = 5000});
  words.hear({.part = Part::draws, .done = 1251, .total = 5000});
  // Each part of the archive has its own rate.
  words.hear({.part = Part::animations, .done = 0, .total = 3000});
  clock.advance(10);
  words.hear({.part = Part::animations, .done = 1000, .total = 3000});
  clock.advance(1);
  words.hear({.part = Part::animations, .done = 0, .total = 0});
  clock.advance(1);
  words.hear({.part = Part::learning, .done = 1'000'000});
  EXPECT_THAT(said, ::testing::ElementsAre(
                        tests::HasFacts("1,250 of 5,000 draws|25%|0:03|1,250 draws/s"),
                        tests::HasFacts("1,000 of 3,000 animations|33%|0:20|100 animations/s"),
                        ::testing::EndsWith(": animations"), tests::HasFacts("1,000,000")));
}

}  // namespace
}  // namespace sleight::coordinator
