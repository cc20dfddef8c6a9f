// Goal: each kind of key is read, checked, described and written according to its declaration.
// Method: bind one key to small sections of a request.
#include "common/request/binder.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/support/facts.h"

namespace sleight::request {
namespace {

/// Runs `bind` on section [s] of the text. Returns the errors. If there are no errors, returns the
/// normalised keys.
std::string bound(std::string_view text, const std::function<void(Binder&)>& bind) {
  const auto document = parse_document(text, "f");
  EXPECT_TRUE(document);
  Diagnostics diagnostics("f");
  Binder binder("s", document.value().find("s"), diagnostics);
  bind(binder);
  std::string told;
  for (const Diagnostic& d : diagnostics.sorted())
    told += to_string(d) + "\n";
  if (!told.empty()) return told;
  for (const BoundKey& key : binder.keys())
    told += key.spec.key + " = " + key.value + "\n";
  return told;
}

std::string number(std::string_view text, const NumberOptions& options, double fallback = 1) {
  return bound(text, [&](Binder& b) { b.number("x", fallback, options); });
}

TEST(BinderNumber, ReadsFloatsIntegersAndDefaults) {
  EXPECT_EQ(number("[s]\nx = 2.5", {}), "x = 2.5\n");
  EXPECT_EQ(number("[s]\nx = 2", {}), "x = 2.0\n");
  EXPECT_EQ(number("[s]\nx = -0.0", {}), "x = 0.0\n");
  EXPECT_EQ(number("[s]", {}), "x = 1.0\n");
  EXPECT_EQ(number("", {}), "x = 1.0\n");
}

TEST(BinderNumber, EndsOfTheRangeAreOpenOrClosed) {
  const NumberOptions closed{.minimum = 0, .maximum = 2};
  const NumberOptions open{
      .minimum = 0, .above_minimum = true, .maximum = 2, .below_maximum = true, .unit = "D"};
  EXPECT_EQ(number("[s]\nx = 0", closed), "x = 0.0\n");
  EXPECT_EQ(number("[s]\nx = 2", closed), "x = 2.0\n");
  EXPECT_THAT(number("[s]\nx = 2.1", closed), tests::LinesHaveFacts("f:2:5: 'x' in [s]: |0|2|2.1"));
  EXPECT_THAT(number("[s]\nx = 0", open),
              tests::LinesHaveFacts("f:2:5: 'x' in [s]: |above|0|below|2 D|0"));
  EXPECT_THAT(number("[s]\nx = 2.0", open),
              tests::LinesHaveFacts("f:2:5: 'x' in [s]: |above|0|below|2 D|2.0"));
}

TEST(BinderNumber, NamesHalfOpenRanges) {
  EXPECT_THAT(number("[s]\nx = -1", {.minimum = 0}),
              tests::LinesHaveFacts("f:2:5: 'x' in [s]: |at least|0|-1"));
  EXPECT_THAT(number("[s]\nx = 2", {.maximum = 1}),
              tests::LinesHaveFacts("f:2:5: 'x' in [s]: |at most|1|2"));
  EXPECT_THAT(number("[s]\nx = nan", {}), tests::LinesHaveFacts("f:2:5: 'x' in [s]: |finite|nan"));
}

TEST(BinderNumber, AnErrorLeavesTheDefault) {
  const auto document = parse_document("[s]\nx = 'a'", "f");
  Diagnostics diagnostics("f");
  Binder binder("s", document.value().find("s"), diagnostics);
  double x = 7;
  binder.number("x", x, {});
  EXPECT_EQ(x, 7);
  EXPECT_TRUE(binder.given("x"));
  EXPECT_FALSE(binder.valid("x"));
  EXPECT_FALSE(binder.valid("y"));
}

TEST(BinderAngle, IsDegreesOutsideAndRadiansInside) {
  double angle = 0.17453292519943295;
  const auto bind = [&](Binder& b) { b.angle_deg("a", angle, {.minimum = 0, .maximum = 90}); };
  EXPECT_EQ(bound("[s]", bind), "a = 10.0\n");
  EXPECT_EQ(angle, 0.17453292519943295);
  EXPECT_EQ(bound("[s]\na = 30", bind), "a = 30.0\n");
  EXPECT_EQ(angle, 30 * 0.017453292519943295);
  EXPECT_THAT(bound("[s]\na = 91", bind),
              tests::LinesHaveFacts("f:2:5: 'a' in [s]: |0|90 degrees|91"));
  EXPECT_EQ(bound("[s]\na = 10.000000000000002", bind), "a = 10.000000000000002\n");
}

TEST(BinderInteger, ReadsItsRangeAndNothingElse) {
  std::uint64_t n = 3;
  const auto bind = [&](Binder& b) {
    b.integer("n", n, {.minimum = 0, .maximum = 9223372036854775807, .unit = "scans"});
  };
  EXPECT_EQ(bound("[s]", bind), "n = 3\n");
  EXPECT_EQ(bound("[s]\nn = 9223372036854775807", bind), "n = 9223372036854775807\n");
  EXPECT_EQ(n, 9223372036854775807U);
  EXPECT_EQ(bound("[s]\nn = 0x1F", bind), "n = 31\n");
  EXPECT_THAT(bound("[s]\nn = -1", bind),
              tests::LinesHaveFacts("f:2:5: 'n' in [s]: |0|9223372036854775807 scans|-1"));
  EXPECT_THAT(
      bound("[s]\nn = 2.0", bind),
      tests::LinesHaveFacts("f:2:5: 'n' in [s]: |integer|0|9223372036854775807 scans|2.0|'.'"));
}

TEST(BinderInteger, MayBeThereOrNot) {
  std::optional<std::uint32_t> n;
  const auto bind = [&](Binder& b) { b.optional_integer("n", n, {.minimum = 1, .maximum = 5}); };
  EXPECT_EQ(bound("[s]", bind), "n = \n");
  EXPECT_EQ(n, std::nullopt);
  EXPECT_THAT(bound("[s]\nn = 6", bind), tests::LinesHaveFacts("f:2:5: 'n' in [s]: |1|5|6"));
  EXPECT_EQ(n, std::nullopt);
  EXPECT_EQ(bound("[s]\nn = 5", bind), "n = 5\n");
  EXPECT_EQ(n, 5U);
}

TEST(BinderBoolean, IsTrueOrFalse) {
  bool flag = true;
  const auto bind = [&](Binder& b) { b.boolean("flag", flag, "help"); };
  EXPECT_EQ(bound("", bind), "flag = true\n");
  EXPECT_EQ(bound("[s]\nflag = false", bind), "flag = false\n");
  EXPECT_THAT(bound("[s]\nflag = 1", bind),
              tests::LinesHaveFacts("f:2:8: 'flag' in [s]: |true|false|1"));
}

TEST(BinderText, CountsCharactersNotBytes) {
  std::string word = "A\"";
  const auto bind = [&](Binder& b) { b.text("word", word, {.characters_max = 3}); };
  EXPECT_EQ(bound("", bind), "word = \"A\\\"\"\n");
  EXPECT_EQ(bound("[s]\nword = '\xc3\xa4\xc3\xa4\xc3\xa4'", bind),
            "word = \"\xc3\xa4\xc3\xa4\xc3\xa4\"\n");
  EXPECT_THAT(bound("[s]\nword = 'four'", bind),
              tests::LinesHaveFacts("f:2:8: 'word' in [s]: |3 characters|\"four\"|4 characters"));
  EXPECT_THAT(bound("[s]\nword = 4", bind),
              tests::LinesHaveFacts("f:2:8: 'word' in [s]: |3 characters|4|\"4\""));
}

enum class Colour { red, green };

TEST(BinderChoice, NamesItsChoicesAndTheNearest) {
  static constexpr std::array k_colours{Named<Colour>{"red", Colour::red},
                                        Named<Colour>{"green", Colour::green}};
  const std::span<const Named<Colour>> colours(k_colours);
  Colour colour = Colour::green;
  const auto bind = [&](Binder& b) { b.choice("c", colour, colours, ""); };
  EXPECT_EQ(bound("", bind), "c = \"green\"\n");
  EXPECT_EQ(bound("[s]\nc = 'red'", bind), "c = \"red\"\n");
  EXPECT_EQ(colour, Colour::red);
  EXPECT_THAT(bound("[s]\nc = 'gren'", bind),
              tests::LinesHaveFacts("f:2:5: 'c' in [s]: |\"red\"|\"green\"|\"gren\"|\"green\""));
  EXPECT_THAT(bound("[s]\nc = 1", bind),
              tests::LinesHaveFacts("f:2:5: 'c' in [s]: |\"red\"|\"green\"|1"));

  const auto required = [&](Binder& b) { b.required_choice("c", colour, colours, ""); };
  EXPECT_THAT(bound("[s]", required),
              tests::LinesHaveFacts("f:1:2: 'c' in [s]: |missing|\"red\"|\"green\""));
  EXPECT_EQ(bound("[s]\nc = 'green'", required), "c = \"green\"\n");
  EXPECT_EQ(colour, Colour::green);
}

TEST(BinderError, IsPlacedAtTheKeyOrItsSection) {
  const auto bind = [](Binder& b) { b.error("k", "at odds with 'j'"); };
  EXPECT_EQ(bound("[s]\n  k = 1", bind), "f:2:3: 'k' in [s]: at odds with 'j'\n");
  EXPECT_EQ(bound("\n[s]", bind), "f:2:2: 'k' in [s]: at odds with 'j'\n");
  EXPECT_EQ(bound("", bind), "f:1:1: 'k' in [s]: at odds with 'j'\n");
}

TEST(BinderNumber, MayBeAbsent) {
  // Goal: an optional number may be absent, but a present number must be in its range.
  const auto bind = [](Binder& b) {
    std::optional<double> x;
    b.optional_number("x", x, {.minimum = 0, .maximum = 2});
  };
  EXPECT_EQ(bound("[s]", bind), "x = \n");
  EXPECT_EQ(bound("[s]\nx = 1", bind), "x = 1.0\n");
  EXPECT_THAT(bound("[s]\nx = 3", bind), tests::LinesHaveFacts("f:2:5: 'x' in [s]: |0|2|3"));
}

TEST(BinderArray, OfAFixedLengthHasADefaultOrNot) {
  std::array<double, 3> at{1, 2, 3};
  const auto bind = [&](Binder& b) { b.numbers("at", at, {.minimum = -9, .unit = "mm"}); };
  EXPECT_EQ(bound("[s]", bind), "at = [1.0, 2.0, 3.0]\n");
  EXPECT_EQ(bound("[s]\nat = [0, -0.0, -2.5]", bind), "at = [0.0, 0.0, -2.5]\n");
  EXPECT_EQ(at, (std::array<double, 3>{0, 0, -2.5}));
  EXPECT_EQ(
      bound("[s]\nat = [1, 2]", bind),
      "f:2:6: 'at' in [s]: expected 3 numbers, each a number of at least -9 mm, found an array "
      "of 2\n");
  EXPECT_EQ(bound("[s]\nat = 5", bind),
            "f:2:6: 'at' in [s]: expected 3 numbers, each a number of at least -9 mm, found 5\n");
  EXPECT_EQ(bound("[s]\nat = [1, \"x\",\n  -10]", bind),
            "f:2:10: 'at' in [s]: element 2: expected a number of at least -9 mm, found the string "
            "\"x\"\n"
            "f:3:3: 'at' in [s]: element 3: expected a number of at least -9 mm, found -10\n");
  EXPECT_EQ(at, (std::array<double, 3>{0, 0, -2.5}));

  std::array<double, 2> maybe{7, 8};
  bool is_given = false;
  const auto bind_optional = [&](Binder& b) { is_given = b.optional_numbers("at", maybe, {}); };
  EXPECT_EQ(bound("[s]", bind_optional), "at = \n");
  EXPECT_THAT(bound("[s]\nat = [nan, 1]", bind_optional),
              tests::LinesHaveFacts("f:2:7: 'at' in [s]: element 1: |a finite number|nan"));
  EXPECT_FALSE(is_given);
  EXPECT_EQ(maybe, (std::array<double, 2>{7, 8}));
  EXPECT_EQ(bound("[s]\nat = [4, 5]", bind_optional), "at = [4.0, 5.0]\n");
  EXPECT_TRUE(is_given);
  EXPECT_EQ(maybe, (std::array<double, 2>{4, 5}));
}

TEST(BinderArray, HasACountOfNumbersOrTexts) {
  std::vector<double> numbers;
  const auto bind = [&](Binder& b) {
    numbers.clear();
    b.numbers("n", numbers, {.count_min = 0, .count_max = 2}, {.minimum = 0});
  };
  EXPECT_EQ(bound("[s]", bind), "n = \n");
  EXPECT_EQ(bound("[s]\nn = []", bind), "n = []\n");
  EXPECT_EQ(bound("[s]\nn = [1, 2.5]", bind), "n = [1.0, 2.5]\n");
  EXPECT_EQ(numbers, (std::vector<double>{1, 2.5}));
  EXPECT_THAT(bound("[s]\nn = [1, 2, 3]", bind),
              tests::LinesHaveFacts("f:2:5: 'n' in [s]: |0 to 2 numbers|an array of 3"));
  EXPECT_THAT(bound("[s]\nn = [1, [2]]", bind),
              tests::LinesHaveFacts("f:2:9: 'n' in [s]: element 2: |at least 0|an array of 1"));
  EXPECT_TRUE(numbers.empty());

  std::vector<std::string> texts;
  const auto bind_texts = [&](Binder& b) {
    texts.clear();
    b.texts("t", texts, {.count_max = 2, .required = true}, {.characters_max = 3});
  };
  EXPECT_EQ(bound("[s]\nt = ['a', \"\\\"\"]", bind_texts), "t = [\"a\", \"\\\"\"]\n");
  EXPECT_EQ(texts, (std::vector<std::string>{"a", "\""}));
  EXPECT_THAT(bound("[s]\n", bind_texts),
              tests::LinesHaveFacts("f:1:2: 't' in [s]: |missing|1 to 2 strings|3 characters"));
  EXPECT_THAT(bound("[s]\nt = ['four', 1]", bind_texts),
              tests::LinesHaveFacts("f:2:6: 't' in [s]: element 1: |3 characters|\"four\"\n"
                                    "f:2:14: 't' in [s]: element 2: |3 characters|1"));
}

TEST(BinderArray, HasRowsOfNumbersOrIntegers) {
  std::vector<std::array<double, 2>> points;
  const auto bind = [&](Binder& b) {
    points.clear();
    b.rows("p", points, {.count_max = 3}, {.maximum = 9});
  };
  EXPECT_EQ(bound("[s]", bind), "p = \n");
  EXPECT_EQ(bound("[s]\np = [[1, 2], [3, -4.5]]", bind), "p = [[1.0, 2.0], [3.0, -4.5]]\n");
  EXPECT_EQ(points, (std::vector<std::array<double, 2>>{{1, 2}, {3, -4.5}}));
  EXPECT_THAT(bound("[s]\np = [[1, 2],\n[3],\n 4, [5, 10]]", bind),
              tests::LinesHaveFacts("f:2:5: 'p' in [s]: |1 to 3 rows of 2 numbers|an array of 4"));
  EXPECT_THAT(bound("[s]\np = [[3],\n 4, [5, 10]]", bind),
              tests::LinesHaveFacts("f:2:6: 'p' in [s]: row 1: |2 numbers|an array of 1\n"
                                    "f:3:2: 'p' in [s]: row 2: |2 numbers|found 4\n"
                                    "f:3:9: 'p' in [s]: row 3, element 2: |at most 9|10"));
  EXPECT_TRUE(points.empty());

  std::vector<std::array<std::uint8_t, 3>> triangles;
  const auto bind_integers = [&](Binder& b) {
    triangles.clear();
    b.rows("t", triangles, {.count_max = 3}, {.minimum = 0, .maximum = 9});
    EXPECT_EQ(b.keys()[0].spec.range, "1 to 3 rows of 3 in 0 .. 9");
  };
  EXPECT_EQ(bound("[s]\nt = [[0, 1, 2]]", bind_integers), "t = [[0, 1, 2]]\n");
  EXPECT_EQ(triangles, (std::vector<std::array<std::uint8_t, 3>>{{0, 1, 2}}));
  EXPECT_THAT(bound("[s]\nt = [[0, 1, 2], [3, 4.0, 10]]", bind_integers),
              tests::LinesHaveFacts("f:2:21: 't' in [s]: row 2, element 2: |integer|4.0\n"
                                    "f:2:26: 't' in [s]: row 2, element 3: |integer|10"));
}

TEST(BinderTables, AreReadOneByOne) {
  // Goal: each table of an array is read with its own values, and errors name the table. Method:
  // bind no table, two tables, too many tables, and a value that is not a table.
  std::vector<double> values;
  std::vector<std::size_t> shown;
  const auto bind = [&](Binder& b) {
    b.tables<double>("t", values, {.count_max = 2}, [](Binder& table, double& value) {
      value = 7;
      table.number("x", value, {.minimum = 0, .maximum = 9});
    });
    ASSERT_EQ(b.bound().tables.size(), 1U);
    const BoundTables& tables = b.bound().tables[0];
    EXPECT_EQ(tables.name, "[s.t]");
    ASSERT_EQ(tables.described.keys.size(), 1U);
    EXPECT_EQ(tables.described.keys[0].value, "7.0");
    shown.push_back(tables.tables.size());
  };
  EXPECT_EQ(bound("", bind), "t = \n");
  EXPECT_EQ(bound("[s]", bind), "t = \n");
  EXPECT_TRUE(values.empty());
  EXPECT_EQ(bound("[[s.t]]\nx = 1\n[[s.t]]\n", bind), "t = \n");
  EXPECT_EQ(values, (std::vector<double>{1, 7}));
  EXPECT_EQ(shown.back(), 2U);
  EXPECT_THAT(bound("[[s.t]]\n[[s.t]]\nx = 10\n", bind),
              tests::LinesHaveFacts("f:3:5: 'x' in [[s.t]]: |0|9|10"));
  EXPECT_THAT(bound("[s]\nt = 4", bind),
              tests::LinesHaveFacts("f:2:5: 't' in [s]: |tables|[[s.t]]|4"));
  EXPECT_EQ(bound("[[s.t]]\n[[s.t]]\n[[s.t]]", bind).substr(0, 3), "f:3");
  EXPECT_TRUE(values.empty());
}

TEST(BinderKeys, TellWhatAKeyIs) {
  Diagnostics diagnostics("f");
  Binder binder("s", nullptr, diagnostics);
  double x = 0.5;
  std::optional<std::uint32_t> n;
  binder.number("x", x,
                {.minimum = 0, .above_minimum = true, .maximum = 1, .unit = "m", .help = "h"});
  binder.number("y", x, {});
  binder.optional_integer("n", n, {.minimum = 1, .maximum = 5});
  ASSERT_EQ(binder.keys().size(), 3U);
  const KeySpec& spec = binder.keys()[0].spec;
  EXPECT_EQ(spec.key, "x");
  EXPECT_EQ(spec.unit, "m");
  EXPECT_EQ(spec.range, "(0, 1]");
  EXPECT_EQ(spec.fallback, "0.5");
  EXPECT_EQ(spec.help, "h");
  EXPECT_EQ(binder.keys()[1].spec.range, "(-inf, inf)");
  EXPECT_EQ(binder.keys()[2].spec.range, "1 .. 5");
  EXPECT_EQ(binder.keys()[2].spec.presence, Presence::optional);
  EXPECT_EQ(x, 0.5);
}

TEST(BinderDeathTest, BugsInABindFunctionStopTheProcess) {
  Diagnostics diagnostics("f");
  double x = 5;
  const auto twice = [&] {
    Binder binder("s", nullptr, diagnostics);
    binder.number("x", x, {});
    binder.number("x", x, {});
  };
  EXPECT_DEATH(twice(), "check failed");
  const auto default_out_of_range = [&] {
    Binder binder("s", nullptr, diagnostics);
    binder.number("x", x, {.maximum = 1});
  };
  EXPECT_DEATH(default_out_of_range(), "check failed");
  const auto range_too_wide = [&] {
    Binder binder("s", nullptr, diagnostics);
    std::uint8_t small = 0;
    binder.integer("x", small, {.minimum = 0, .maximum = 256});
  };
  EXPECT_DEATH(range_too_wide(), "check failed");
  const auto too_many = [&] {
    Binder binder("s", nullptr, diagnostics);
    std::vector<std::array<double, 2>> rows;
    binder.rows("x", rows, {.count_max = k_array_numbers_max / 2 + 1}, {});
  };
  EXPECT_DEATH(too_many(), "check failed");
}

}  // namespace
}  // namespace sleight::request
