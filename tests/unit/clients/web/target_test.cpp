// Goal: a plain target is decoded once. A target that another program could read as a different
// path is refused.
#include "clients/web/target.h"

#include <gtest/gtest.h>

#include <string>

namespace sleight::web {
namespace {

std::string path_of(const std::string& target) {
  const auto parsed = parse_target(target);
  return parsed ? parsed->path : "refused";
}

TEST(Targets, PlainOnesAreDecodedOnce) {
  EXPECT_EQ(path_of("/"), "/");
  EXPECT_EQ(path_of("/a/b.js"), "/a/b.js");
  EXPECT_EQ(path_of("/a//b/"), "/a//b/");
  EXPECT_EQ(path_of("/die%201"), "/die 1");
  EXPECT_EQ(path_of("/a+b"), "/a+b");
  EXPECT_EQ(path_of("/%C3%A9"), "/\xc3\xa9");
  // If a text was encoded twice, it is still decoded only once.
  EXPECT_EQ(path_of("/%2525"), "/%25");
  EXPECT_EQ(path_of("/%252e%252e/"), "/%2e%2e/");
  // Names may contain dots; only "." and ".." are refused.
  EXPECT_EQ(path_of("/..a/.b/c..d/..."), "/..a/.b/c..d/...");
  EXPECT_EQ(path_of("/" + std::string(k_target_bytes_max - 1, 'a')).size(), k_target_bytes_max);
}

TEST(Targets, OthersAreRefused) {
  for (const std::string target : {"",          "a",
                                   "*",         "http://127.0.0.1/",
                                   "?a",        "/..",
                                   "/../a",     "/a/..",
                                   "/a/../b",   "/./a",
                                   "/a/.",      "/%2e%2e/a",
                                   "/%2E./a",   "/.%2e",
                                   "/a%2fb",    "/a%2Fb",
                                   "/a\\b",     "/a%5cb",
                                   "/%00",      "/a%00.js",
                                   "/%0a",      "/%0d%0a",
                                   "/%7f",      "/%1f",
                                   "/%",        "/%1",
                                   "/%zz",      "/%4",
                                   "/a b",      "/a#b",
                                   "/\xc3\xa9", "/%c3",
                                   "/%ff",      "/%c0%ae%c0%ae/",
                                   "/?a=%",     "/?%00",
                                   "/?a=%0a",   "/?a=%ff",
                                   "/?a=b\\c"}) {
    EXPECT_EQ(path_of(target), "refused") << target;
  }
  EXPECT_EQ(path_of(std::string("/a\0b", 4)), "refused");
  EXPECT_EQ(path_of("/" + std::string(k_target_bytes_max, 'a')), "refused");
}

TEST(Targets, ParametersStandInOrder) {
  const auto parsed = parse_target("/a?x=1&&y=a%26b%3dc&x=2+3%2B&flag&=v&z=a=b");
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->path, "/a");
  std::string said;
  for (const Parameter& parameter : parsed->parameters)
    said += "[" + parameter.name + "|" + parameter.value + "]";
  EXPECT_EQ(said, "[x|1][y|a&b=c][x|2 3+][flag|][|v][z|a=b]");
  const auto dots = parse_target("/?p=../..%2f%5c");
  ASSERT_TRUE(dots);
  EXPECT_EQ(dots->parameters.at(0).value, "../../\\");
  const Ask ask{.parameters = parsed->parameters};
  EXPECT_EQ(ask.parameter("x"), "1");
  EXPECT_EQ(ask.parameter("flag"), "");
  EXPECT_FALSE(ask.parameter("X"));
}

}  // namespace
}  // namespace sleight::web
