// Goal: nearest() finds the intended name after a typing error, and no name for unrelated words.
// Method: compare edit distances with known values and with a slow recursive reference. Try typical
// typing errors.
#include "common/request/nearest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace sleight::request {
namespace {

/// Computes the edit distance by its recursive definition.
std::size_t slow_distance(std::string_view a, std::string_view b) {
  if (a.empty()) return b.size();
  if (b.empty()) return a.size();
  const auto shorter = [](std::string_view s) { return s.substr(0, s.size() - 1); };
  std::size_t least = std::min({slow_distance(shorter(a), b) + 1, slow_distance(a, shorter(b)) + 1,
                                slow_distance(shorter(a), shorter(b)) + (a.back() != b.back())});
  if (a.size() > 1 && b.size() > 1 && a.back() == b[b.size() - 2] && b.back() == a[a.size() - 2]) {
    least =
        std::min(least, slow_distance(a.substr(0, a.size() - 2), b.substr(0, b.size() - 2)) + 1);
  }
  return least;
}

TEST(EditDistance, CountsEachKindOfEditOnce) {
  EXPECT_EQ(edit_distance("lambda", "lambda"), 0U);
  EXPECT_EQ(edit_distance("lamda", "lambda"), 1U);
  EXPECT_EQ(edit_distance("chians", "chains"), 1U);
  EXPECT_EQ(edit_distance("seet", "seed"), 1U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
}

TEST(EditDistance, AgreesWithItsDefinition) {
  std::uint32_t state = 7;
  const auto word = [&] {
    std::string letters;
    state = state * 1664525U + 1013904223U;
    for (std::uint32_t i = 0, length = (state >> 16) % 7; i < length; ++i) {
      state = state * 1664525U + 1013904223U;
      letters += static_cast<char>('a' + (state >> 16) % 3);
    }
    return letters;
  };
  for (int i = 0; i < 2000; ++i) {
    const std::string a = word();
    const std::string b = word();
    ASSERT_EQ(edit_distance(a, b), slow_distance(a, b)) << a << " " << b;
  }
}

TEST(Nearest, FindsWhatWasMeant) {
  const std::vector<std::string> known{"chains", "seed", "iterations_per_scan", "sigma_diameters",
                                       "thin"};
  EXPECT_EQ(nearest("chian", known), "chains");
  EXPECT_EQ(nearest("Seeds", known), "seed");
  EXPECT_EQ(nearest("ITERATIONS-PER-SCAN", known), "iterations_per_scan");
  EXPECT_EQ(nearest("iteration_per_scans", known), "iterations_per_scan");
  EXPECT_EQ(nearest("sigma", known), "sigma_diameters");
  EXPECT_EQ(nearest("thin_scans", known), "thin");
}

TEST(Nearest, FindsNothingFarAway) {
  const std::vector<std::string> known{"chains", "seed", "thin"};
  EXPECT_EQ(nearest("colour", known), std::nullopt);
  EXPECT_EQ(nearest("x", known), std::nullopt);
  EXPECT_EQ(nearest("", known), std::nullopt);
  EXPECT_EQ(nearest(std::string(1000, 'c'), known), std::nullopt);
  EXPECT_EQ(nearest("chains", std::vector<std::string>{}), std::nullopt);
}

TEST(Nearest, TakesTheEarlierOfEquals) {
  EXPECT_EQ(nearest("abcd", std::vector<std::string>{"abcx", "abcy"}), "abcx");
}

}  // namespace
}  // namespace sleight::request
