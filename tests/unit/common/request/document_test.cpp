// Goal: a TOML file is read as sections and keys, and each has its place in the file. If a file
// could harm the TOML parser, it never reaches the parser. Method: read valid examples. Read
// hostile files at and beyond each limit.
#include "common/request/document.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include "tests/support/facts.h"

namespace sleight::request {
namespace {

Document parsed(std::string_view text) {
  auto document = parse_document(text, "f.toml");
  EXPECT_TRUE(document) << to_string(document.error());
  return std::move(document).value();
}

std::string error_of(std::string_view text) {
  const auto document = parse_document(text, "f.toml");
  return document ? "" : to_string(document.error());
}

TEST(Document, KeepsSectionsAndKeysInFileOrderWithPlaces) {
  const Document document = parsed("top = 1\n[b]\n  z = 'q'\na = 2.5\n[a]\n");
  ASSERT_EQ(document.sections.size(), 2U);
  ASSERT_EQ(document.loose.size(), 1U);
  EXPECT_EQ(document.loose[0].key, "top");
  const Section& b = document.sections[0];
  EXPECT_EQ(b.name, "b");
  EXPECT_EQ(b.place, (Place{2, 2}));
  ASSERT_EQ(b.entries.size(), 2U);
  EXPECT_EQ(b.entries[0].key, "z");
  EXPECT_EQ(b.entries[0].place, (Place{3, 3}));
  EXPECT_EQ(b.entries[0].value.place, (Place{3, 7}));
  EXPECT_EQ(std::get<std::string>(b.entries[0].value.held), "q");
  EXPECT_EQ(std::get<double>(b.find("a")->value.held), 2.5);
  EXPECT_EQ(b.find("top"), nullptr);
  EXPECT_EQ(document.find("a")->place, (Place{5, 2}));
  EXPECT_EQ(document.find("c"), nullptr);
}

TEST(Document, KeepsArraysOfTables) {
  // Goal: the tables of an array are read in order, with their places. An array of numbers is not
  // an array of tables. Method: use both of TOML's notations for an array of tables. Also use an
  // array of numbers.
  const Document document = parsed(
      "[a]\nk = 1\n[[a.t]]\ny = 2\n\n  [[a.t]]\nx = 3\ny = 4\n[b]\nt = [{x = 5}]\nu = [1]\n");
  const Section& a = document.sections[0];
  EXPECT_EQ(a.entries.size(), 2U);
  EXPECT_EQ(description(a.find("t")->value), "an array");
  EXPECT_TRUE(a.tables("k").empty());
  const std::vector<const Section*> tables = a.tables("t");
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_EQ(tables[0]->place.line, 3U);
  EXPECT_EQ(tables[1]->place.line, 6U);
  EXPECT_EQ(tables[0]->entries[0].place, (Place{4, 1}));
  EXPECT_EQ(std::get<std::int64_t>(tables[1]->find("y")->value.held), 4);
  const Section& b = document.sections[1];
  ASSERT_EQ(b.tables("t").size(), 1U);
  EXPECT_EQ(std::get<std::int64_t>(b.tables("t")[0]->find("x")->value.held), 5);
  EXPECT_TRUE(b.tables("u").empty());
}

TEST(Document, KeepsArraysAndTablesWithPlaces) {
  // Goal: every element of an array and every table has its place, at any depth. Method: read
  // nested arrays, and tables in each of TOML's notations.
  const Document document = parsed(
      "[a]\nr = [[1, 2],\n  [\"x\"]]\ni = {k = 1}\nd.k = 2\n[a.h]\nk = 3\n"
      "[[a.t]]\n[a.t.s]\nk = 4\n[[a.t.u]]\nk = 5\n");
  const Section& a = document.sections[0];
  const auto& rows = std::get<std::vector<Value>>(a.find("r")->value.held);
  const auto& row = std::get<std::vector<Value>>(rows.at(1).held);
  EXPECT_EQ(rows[1].place, (Place{3, 3}));
  EXPECT_EQ(std::get<std::string>(row.at(0).held), "x");
  EXPECT_EQ(row[0].place, (Place{3, 4}));
  const auto check = [](const Section* table, std::int64_t k, Place place) {
    ASSERT_NE(table, nullptr);
    EXPECT_EQ(std::get<std::int64_t>(table->find("k")->value.held), k);
    EXPECT_EQ(table->place, place);
  };
  check(a.table("i"), 1, {4, 1});
  check(a.table("d"), 2, {5, 1});
  check(a.table("h"), 3, {6, 4});
  ASSERT_EQ(a.tables("t").size(), 1U);
  check(a.tables("t")[0]->table("s"), 4, {9, 6});
  ASSERT_EQ(a.tables("t")[0]->tables("u").size(), 1U);
  EXPECT_EQ(a.table("r"), nullptr);
}

TEST(Document, ReadsNumbersWhateverTheLocaleAndHoweverSmall) {
  const Document document =
      parsed("[s]\na = 4.9406564584124654e-324\nb = +1_000.5\nc = 1e-05\nd = 1e+22\n");
  const Section& s = document.sections[0];
  EXPECT_EQ(std::get<double>(s.find("a")->value.held), 4.9406564584124654e-324);
  EXPECT_EQ(std::get<double>(s.find("b")->value.held), 1000.5);
  EXPECT_EQ(std::get<double>(s.find("c")->value.held), 1e-5);
  EXPECT_EQ(std::get<double>(s.find("d")->value.held), 1e22);
}

TEST(Document, RefusesMoreThanAMegabyte) {
  EXPECT_EQ(error_of(std::string(k_request_bytes_max, '\n')), "");
  EXPECT_THAT(error_of(std::string(k_request_bytes_max + 1, '\n')),
              tests::LinesHaveFacts("f.toml:1:1: |1048577 bytes|1048576"));
}

std::string repeated(std::string_view piece, std::size_t times) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i)
    all += piece;
  return all;
}

TEST(Document, RefusesDeepKeysInEveryDisguise) {
  EXPECT_EQ(error_of("a" + repeated(".a", k_dots_per_line_max) + " = 1"), "");
  EXPECT_THAT(error_of("a" + repeated(".a", k_dots_per_line_max + 1) + " = 1"),
              tests::LinesHaveFacts("f.toml:1:202: |100 dots"));
  for (const std::string& deep :
       {"[a" + repeated(".a", 200000) + "]", "a" + repeated(" . \"a\"", 100000) + " = 1",
        "a = { a" + repeated(".a", 200000) + " = 1 }"}) {
    EXPECT_NE(error_of(deep).find("not nested"), std::string::npos);
  }
  for (const std::string& deep : {"a = " + repeated("[", 500000), "a = " + repeated("{a=", 300000),
                                  "a = " + repeated("[{a.a.a.a=", 100000)}) {
    EXPECT_NE(error_of(deep), "");
  }
}

TEST(Document, TakesBitmapsOnOneLine) {
  // Goal: the largest bitmap can be read from one line, although the line has many dots. A long
  // dotted key is refused, even if a text on its line has many dots. Method: read a bitmap of 12
  // rows, each of 40 characters. Then read a line that has such a bitmap and a long dotted key.
  const std::string bitmap = "a = \"" + repeated(repeated(".", 39) + "#\\U0000000A", 6) +
                             repeated(repeated(".", 40) + "\\U0000000A", 6) + "\"";
  EXPECT_EQ(error_of(bitmap), "");
  EXPECT_NE(
      error_of("a = { b = \"" + repeated(".", 300) + "\", c" + repeated(".c", 200000) + " = 1 }")
          .find("not nested"),
      std::string::npos);
}

TEST(Document, TakesDecimalNumbersOnOneLine) {
  // Goal: a number's decimal point doesn't count as a dot of a key, but keys of digits have a
  // limit. Method: read the most numbers of a request. Then read keys of digits in disguises.
  std::string numbers = "a = [" + repeated("-0.5, ", 59996) + "1_0.5e-3 ,+1.5,[2.5],2.5]";
  ASSERT_LE(numbers.size(), k_request_bytes_max);
  EXPECT_EQ(error_of(numbers), "");
  for (const std::string& deep :
       {"1" + repeated(".1", 200000) + " = 1", "[1" + repeated(".1", 200000) + "]",
        "1.1" + repeated(" . 1.1", 100000) + " = 1", "1.1" + repeated(".a.1", 100000) + " = 1",
        "a = {1" + repeated(" .1. 1", 100000) + " = 1}",
        "1.1" + repeated(".'1'.1", 100000) + " = 1"}) {
    EXPECT_NE(error_of(deep).find("not nested"), std::string::npos) << deep.substr(0, 20);
  }
}

TEST(Document, HoldsTheDeepestFileThatIsAllowed) {
  // Nest pairs of an array and an inline table. Each line has the maximum number of dots. Four
  // nested pairs are too deep; three are accepted.
  std::string deep = "a" + repeated(".a", k_dots_per_line_max) + " = ";
  for (int i = 0; i < 4; ++i)
    deep += "[\n{ a" + repeated(".a", k_dots_per_line_max) + " = ";
  EXPECT_NE(error_of(deep + "1"), "");
  deep += "1";
  for (int i = 0; i < 4; ++i)
    deep += " } ]";
  EXPECT_NE(error_of(deep), "");
  deep = "a" + repeated(".a", k_dots_per_line_max) + " = ";
  for (int i = 0; i < 3; ++i)
    deep += "[\n{ a" + repeated(".a", k_dots_per_line_max) + " = ";
  deep += "1";
  for (int i = 0; i < 3; ++i)
    deep += " } ]";
  EXPECT_EQ(error_of(deep), "");
}

TEST(Diagnostics, AreSortedAndCounted) {
  Diagnostics diagnostics("f\x1b.toml");
  EXPECT_TRUE(diagnostics.empty());
  diagnostics.add({2, 1}, "c");
  diagnostics.add({1, 9}, "a");
  diagnostics.add({2, 1}, "d");
  diagnostics.add({1, 10}, "b");
  std::string lines;
  for (const Diagnostic& d : diagnostics.sorted())
    lines += to_string(d) + "\n";
  EXPECT_EQ(lines,
            "f\\u{1b}.toml:1:9: a\nf\\u{1b}.toml:1:10: b\nf\\u{1b}.toml:2:1: c\n"
            "f\\u{1b}.toml:2:1: d\n");

  Diagnostics many("f");
  for (std::uint32_t i = 1; i <= k_diagnostics_max + 5; ++i)
    many.add({i, 1}, "m");
  const auto sorted = many.sorted();
  ASSERT_EQ(sorted.size(), k_diagnostics_max + 1);
  EXPECT_EQ(to_string(sorted.back()), "f:201:1: 5 more errors are not shown");
}

}  // namespace
}  // namespace sleight::request
