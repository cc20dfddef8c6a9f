// Goal: a query means what its text states, and the fast answer equals the slow one. Method: answer
// random queries about random animations. Compare the answers with those of tests/browse, which
// tests every segment of every body. Check small cases with known answers. Check that the
// comparison detects wrong answers.
#include "clients/browse/query.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/browse/slow_query.h"
#include "tests/support/property.h"
#include "tests/unit/clients/browse/random_index.h"

namespace sleight::browse::query_test {

using testing::below;
using testing::random_index;

constexpr std::uint64_t k_seed = 26;

TEST(Queries, AreAnsweredAsSlowlyAndPlainly) {
  std::uint64_t met = 0;
  std::uint64_t asked = 0;
  std::uint64_t close = 0;
  for (const std::uint64_t n : property::cases(2000)) {
    random::Stream stream = testing::stream_of(k_seed, n);
    const Index index = random_index(4, stream);
    for (int i = 0; i < 10; ++i) {
      const Condition condition = testing::random_condition(index, stream, 3);
      const std::vector<std::size_t> found = find(condition, index);
      for (std::size_t row = 0; row < index.entries.size(); ++row) {
        const Entry& entry = index.entries[row];
        const bool is_found = std::ranges::binary_search(found, row);
        ++asked;
        if (is_found) ++met;
        if (is_found == testing::slow_is_met(condition, entry)) continue;
        ++close;
        EXPECT_TRUE(testing::is_close_call(condition, entry));
      }
    }
  }
  if (property::all_cases()) {
    // Between a tenth and nine tenths of the answers must be positive, and rounding may decide less
    // than a thousandth of them.
    EXPECT_GT(met, asked / 10);
    EXPECT_LT(met, asked - asked / 10);
    EXPECT_LT(close, asked / 1000);
  }
}

TEST(Queries, TheComparisonNoticesAnswersThatAreWrong) {
  // Sampling paths at 30 frames a second would give wrong answers.
  std::uint64_t missed = 0;
  for (std::uint64_t n = 0; n < 300; ++n) {
    random::Stream stream = testing::stream_of(k_seed, n);
    const Index index = random_index(1, stream);
    const Entry& entry = index.entries.front();
    const double t_s = entry.end_s * stream.uniform();
    const auto middle_m = centre_at(entry.pieces_of(0), t_s);
    if (!middle_m) continue;
    const math::Vec3 half_m = math::Vec3::Constant(0.01);
    const Inside small{.who = {.bodies = {0}},
                       .box = {.low_m = *middle_m - half_m, .high_m = *middle_m + half_m}};
    bool is_sampled = false;
    for (int frame = 0; frame < 90; ++frame) {
      const auto centre = centre_at(entry.pieces_of(0), frame / 30.0);
      is_sampled = is_sampled || (centre && (*centre - *middle_m).cwiseAbs().maxCoeff() <= 0.01);
    }
    const bool is_met_slowly = testing::slow_is_met({small}, entry);
    EXPECT_TRUE(is_met_slowly || !is_sampled);
    if (is_met_slowly && !is_sampled) ++missed;
  }
  EXPECT_GT(missed, 50U);
}

/// A ball thrown up from 1 m and to the right comes to rest at 1.5 s after hitting the table twice.
/// Another ball enters at 1 s and rests.
Index known() {
  Index index{.run_id = "run", .world = "made up", .scene = testing::small_scene()};
  index.numbers = own_numbers();
  Entry entry{.name = {.run = "run"}, .end_s = 1.5, .events = 2};
  entry.tracks = {{.first = 0, .count = 3}, {.first = 3, .count = 1}, {.first = 4, .count = 0}};
  entry.pieces = {{.start_s = 0,
                   .position_m = {0, 0, 1},
                   .velocity_mps = {1, 0, 5},
                   .acceleration_mps2 = {0, 0, -10}},
                  {.start_s = 1, .position_m = {1, 0, 1}, .velocity_mps = {1, 0, 0}},
                  {.start_s = 1.5, .position_m = {1.5, 0, 1}},
                  {.start_s = 1, .position_m = {-1, 0.5, 0.25}}};
  entry.contacts = {{.time_s = 1, .body = 0, .partner = 3},
                    {.time_s = 1.5, .body = 0, .partner = 1}};
  measure_reach(entry);
  entry.numbers.assign(k_own_numbers, 0);
  entry.numbers[k_log_prior] = -3;
  entry.numbers[k_rest_s] = 1.5;
  index.entries.push_back(std::move(entry));
  return index;
}

bool is_met(const std::string& text) {
  const Index index = known();
  const auto condition = parse_query(text, index.scene, index.numbers);
  EXPECT_TRUE(condition.ok()) << with_mark(condition.error(), text);
  return condition.ok() && !find(condition.value(), index).empty();
}

TEST(Queries, MeanWhatTheySay) {
  // The top of the throw, at 2.25 m and 0.5 s, belongs to the region; higher points don't.
  EXPECT_TRUE(is_met("ball 1 in z 2.25.."));
  EXPECT_FALSE(is_met("ball 1 in z 2.251.."));
  EXPECT_TRUE(is_met("ball 1 in z 2.2.. during 400..450ms"));
  EXPECT_FALSE(is_met("ball 1 in z 2.2.. during 0..300ms"));
  EXPECT_TRUE(is_met("ball 1: x 49..51cm z 2.2.."));
  EXPECT_FALSE(is_met("ball 1: x 80..90cm z 2.2.."));
  // A ball stays where it rests, and has no position before it enters.
  EXPECT_TRUE(is_met("ball 1 in x 1.5..1.5 during 100s.."));
  EXPECT_FALSE(is_met("ball 2 in x -2..2 during ..0.99"));
  EXPECT_TRUE(is_met("ball 2 in x -2..2 during ..1"));
  EXPECT_FALSE(is_met("\"odd \\\"one\\\"\" in x -9..9"));
  EXPECT_TRUE(is_met("any in x -1..-1"));
  EXPECT_FALSE(is_met("every in x -1..-1"));
  EXPECT_TRUE(is_met("any body in x -1..-1"));
  EXPECT_FALSE(is_met("every body in x -1..-1"));
  EXPECT_TRUE(is_met("every ball ends in z 0.2..1"));
  EXPECT_FALSE(is_met("every ball ends in z 0.5..1"));
  EXPECT_TRUE(is_met("ball 1 touches table"));
  EXPECT_TRUE(is_met("ball 2 touches ball 1"));
  EXPECT_TRUE(is_met("ball 2 touches any"));
  EXPECT_FALSE(is_met("ball 2 touches table"));
  EXPECT_TRUE(is_met("ball 1 touches table during 1..1s"));
  EXPECT_FALSE(is_met("ball 1 touches table during 1001ms.."));
  // In "a then b", a single hit can't count as both a and b.
  EXPECT_TRUE(is_met("ball 1 touches table then ball 1 touches ball 2"));
  EXPECT_FALSE(is_met("ball 1 touches ball 2 then ball 1 touches table"));
  EXPECT_FALSE(is_met("ball 1 touches table then ball 1 touches table"));
  EXPECT_FALSE(is_met("ball 1 touches table then ball 1 in z ..9 then ball 1 touches table"));
  EXPECT_TRUE(is_met("ball 1 touches table then ball 1 in z ..9 then ball 1 touches ball 2"));
  EXPECT_TRUE(is_met("ball 1 in z 2.2.. then ball 1 touches table then ball 1 in x 1.4.."));
  EXPECT_FALSE(is_met("ball 1 touches table then ball 1 in z 2.."));
  // "not" binds more tightly than "and", and "and" more tightly than "or".
  EXPECT_TRUE(is_met("log_prior -3..-3 and rest_s > 1499ms"));
  EXPECT_FALSE(is_met("log_prior < -3"));
  EXPECT_TRUE(is_met("log_prior <= -3"));
  EXPECT_TRUE(is_met("log_prior = 0 and log_prior = 0 or log_prior = -3"));
  EXPECT_FALSE(is_met("log_prior = 0 and (log_prior = 0 or log_prior = -3)"));
  EXPECT_TRUE(is_met("not log_prior = 0 and not (log_prior = -3 and ball 2 touches table)"));
}

TEST(Queries, ErrorsPointAtThePlace) {
  const Index index = known();
  const auto fails = [&](const std::string& text, std::size_t column,
                         const std::string& suggested = "") {
    const auto condition = parse_query(text, index.scene, index.numbers);
    ASSERT_FALSE(condition.ok()) << text;
    EXPECT_EQ(condition.error().column, column) << text << ": " << condition.error().message;
    EXPECT_NE(condition.error().message.find(suggested), std::string::npos)
        << text << ": " << condition.error().message;
  };
  fails("", 0);
  fails("ball 3 in x 0..1", 0, "did you mean 'ball");
  fails("any die in x 0..1", 4);
  fails("any in x 0..1 furlongs", 14);
  fails("any in x 0..1s", 13);
  fails("any in x 3..1", 9);
  fails("any in x ..", 9);
  fails("any in x 0..1 x 0..1", 14);
  fails("any in during 0..1", 7);
  fails("ball 1 touches target", 15);
  fails("table in x 0..1", 0);
  fails("log_priro < 3", 0, "did you mean 'log_prior'");
  fails("plausibility < 3", 0, "did you mean 'log_prior'");
  fails("log_prior", 0);
  fails("(any in x 0..1", 14);
  fails("log_prior < 3 then any in x 0..1", 0);
  fails("any in x 0..1 then log_prior < 3", 19);
  fails("any in x 0..1 then not any in x 0..1", 19);
  fails("any in x 0..1 then (any in x 0..1)", 19);
  fails("any in x 0..1 ; rm", 14);
  fails("\"ball 1 in x", 0);
  fails("any in x 1e999..", 9);
  std::string nested(101, '(');
  nested.append("log_prior = 0").append(101, ')');
  fails(nested, 100);
  fails(std::string(k_query_bytes_max + 1, ' '), k_query_bytes_max);
  EXPECT_EQ(with_mark({.column = 4, .message = "what?"}, "any dye"),
            "column 5: what?\n  any dye\n      ^");
  // A long text is cut around the error; a multi-byte character takes one column.
  const std::string e = "\xc3\xa9";
  EXPECT_EQ(with_mark({.column = 3, .message = "what?"}, e + " x"),
            "column 3: what?\n  " + e + " x\n    ^");
  const std::string of_long =
      with_mark({.column = 10'000, .message = "what?"}, std::string(20'000, 'x'));
  EXPECT_LT(of_long.size(), 300U);
  EXPECT_EQ(of_long.substr(of_long.rfind('\n')), "\n" + std::string(2 + 4 + 60, ' ') + "^");
}

TEST(Queries, AnyBytesAreAnErrorOrAQuery) {
  const Index index = known();
  const std::string signs =
      "any every ball 1 in x..0.5mm\"\\()<>=,:[]\n\t\xc3\xa9\x01 then not and";
  for (const std::uint64_t n : property::cases(20'000)) {
    random::Stream stream = testing::stream_of(k_seed, n);
    std::string text;
    for (std::uint64_t i = below(stream, 40); i > 0; --i)
      text += signs[below(stream, signs.size())];
    const auto condition = parse_query(text, index.scene, index.numbers);
    if (condition.ok()) {
      static_cast<void>(find(condition.value(), index));
    } else {
      EXPECT_LE(condition.error().column, text.size());
      static_cast<void>(with_mark(condition.error(), text));
    }
  }
}

}  // namespace sleight::browse::query_test
