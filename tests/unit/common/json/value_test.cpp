// Goal: JSON values keep the order of keys and the exact value of numbers, and enforce the limits
// of common/json. The JSON library's own tests cover the grammar.
#include "common/json/value.h"

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sleight::json {
namespace {

TEST(JsonValue, KeepsTheOrderOfKeysAndOneValueForEach) {
  // Goal: the keys of an object stay in the order in which they were inserted, and each key has one
  // value.
  Value value{{"z", 1}, {"a", Value::object()}};
  value["m"] = "x";
  value["z"] = nullptr;
  EXPECT_EQ(value.dump(), R"({"z":null,"a":{},"m":"x"})");
  EXPECT_EQ(Value::parse(R"({"b": 1, "a": 2, "b": 3})").dump(), R"({"b":3,"a":2})");
  EXPECT_EQ(Value::parse(R"({"b": 1, "a": 2})"), Value::parse(R"({"a": 2, "b": 1})"));
  value.erase("a");
  value.update({{"m", 2}, {"new", true}});
  EXPECT_EQ(value.dump(), R"({"z":null,"m":2,"new":true})");
}

TEST(JsonValue, BracesMakeAnObjectOfPairsAndElseAnArray) {
  // Goal: a braced list of key-value pairs makes an object, and any other braced list makes an
  // array.
  EXPECT_EQ((Value{{"a", 1}, {"b", {1, 2}}}).dump(), R"({"a":1,"b":[1,2]})");
  EXPECT_EQ((Value{{1, "a"}, {2, "b"}}).dump(), R"([[1,"a"],[2,"b"]])");
  EXPECT_EQ(Value::array({{"a", 1}}).dump(), R"([["a",1]])");
  EXPECT_EQ(Value(std::vector<double>{1, 0.1, 1e300}).dump(), "[1.0,0.1,1e+300]");
  EXPECT_EQ(Value(std::map<std::string, int>{{"a", -1}}).dump(), R"({"a":-1})");
}

TEST(JsonValue, NumbersComeBackAsTheyWere) {
  // Goal: numbers read back exactly as they were written, even the largest and the smallest
  // integers.
  constexpr auto k_most = std::numeric_limits<std::uint64_t>::max();
  constexpr auto k_least = std::numeric_limits<std::int64_t>::min();
  EXPECT_EQ(Value::parse(Value(k_most).dump()).get<std::uint64_t>(), k_most);
  EXPECT_EQ(Value::parse(Value(k_least).dump()).get<std::int64_t>(), k_least);
  EXPECT_EQ(Value::parse(Value(0.1).dump()).get<double>(), 0.1);
  EXPECT_EQ(Value(std::numeric_limits<double>::quiet_NaN()).dump(), "null");
  EXPECT_EQ(Value(-3).get<double>(), -3);
  EXPECT_NE(Value(k_most), Value(k_most - 1));
  EXPECT_EQ(Value(2), Value(2.0));
}

TEST(JsonValue, AValueOfAnotherKindIsRefused) {
  // Goal: reading a value as a wrong type, or as a type that can't hold it, throws an error.
  EXPECT_THROW(Value(256).get<std::uint8_t>(), Error);
  EXPECT_THROW(Value(-1).get<std::uint64_t>(), Error);
  EXPECT_THROW(Value(std::uint64_t{1} << 63U).get<std::int64_t>(), Error);
  EXPECT_THROW(Value(1.5).get<int>(), Error);
  EXPECT_THROW(Value(1).get<bool>(), Error);
  EXPECT_THROW(Value("1").get<double>(), Error);
  EXPECT_THROW(Value().text(), Error);
  EXPECT_THROW(Value(1)["a"] = 2, Error);
  EXPECT_THROW(Value("a").push_back(1), Error);
  EXPECT_THROW(Value::object().at("a"), Error);
  EXPECT_THROW(Value::array().at(0), Error);
  EXPECT_EQ((Value{{"a", 1}}).value("b", 7), 7);
  EXPECT_THROW((Value{{"a", 1}}).value("a", "text"), Error);
}

TEST(JsonValue, TextThatIsNotJsonIsRefused) {
  // Goal: truncated, invalid and too deeply nested texts are refused.
  const auto nested = [](int depth) {
    return std::string(static_cast<std::size_t>(depth), '[') +
           std::string(static_cast<std::size_t>(depth), ']');
  };
  EXPECT_EQ(Value::parse(nested(k_depth_max)).size(), 1U);
  for (const std::string& text : {std::string(), std::string("[1,"), std::string("\"\xff\""),
                                  std::string("1e999"), nested(k_depth_max + 2), nested(100'000)}) {
    EXPECT_THROW(Value::parse(text), Error) << text.substr(0, 20);
    EXPECT_TRUE(Value::parse_or_null(text).is_null()) << text.substr(0, 20);
  }
}

TEST(JsonValue, WhatIsNotUtf8IsReplaced) {
  // Goal: dump() replaces invalid UTF-8, and writes pure ASCII on request.
  EXPECT_EQ(Value("a\xff").dump(), "\"a\uFFFD\"");
  EXPECT_EQ(Value("\u00e9\n").dump(-1, true), R"("\u00e9\n")");
}

}  // namespace
}  // namespace sleight::json
