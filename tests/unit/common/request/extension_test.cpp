// Goal: extending a request changes only the section [stop], so that the run can resume its chains.
// Method: extend requests of a toy world and read the new texts.
#include "common/request/extension.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/unit/common/request/toy_world.h"

namespace sleight::request::extension_test {

using testing::HasSubstr;

DirectionRequest read(const std::string& text) {
  const std::array worlds{toy::binding()};
  auto request = read_request(text, "r.toml", worlds);
  if (!request) {
    for (const auto& d : request.error())
      ADD_FAILURE() << to_string(d);
    return {};
  }
  return std::move(request).value();
}

DirectionRequest request_with(const std::string& stop) {
  return read("[world]\nname = 'toy'\n[sampler]\nchains = 7\n[stop]\n" + stop + "\n");
}

DirectionRequest longer(const DirectionRequest& request, const Extension& extension) {
  const auto text = extended_text(request, extension);
  EXPECT_TRUE(text.ok()) << (text.ok() ? "" : text.error().why);
  return text.ok() ? read(text.value()) : DirectionRequest{};
}

std::string why_not(const DirectionRequest& request, const Extension& extension) {
  const auto text = extended_text(request, extension);
  return text.ok() ? "" : text.error().why;
}

TEST(Extension, IsTheSameRequestWithALongerStop) {
  const DirectionRequest before = request_with("scans = 10");
  EXPECT_EQ(longer(before, {.scans = 25}), request_with("scans = 25"));
  EXPECT_EQ(identity_text(longer(before, {.scans = 25})), identity_text(before));
}

TEST(Extension, TakesThePlaceOfOtherRules) {
  const DirectionRequest before = request_with("scans = 10\nindependent_solutions = 2");
  EXPECT_EQ(longer(before, {.rounds = 3}), request_with("rounds = 3"));
  EXPECT_EQ(longer(before, {.scans = 11, .solutions = 4}),
            request_with("scans = 11\nindependent_solutions = 4"));
}

TEST(Extension, MoreTakesAreTakes) {
  const std::array worlds{toy::relaxing_binding()};
  const auto with = [&](const std::string& stop) {
    return read_request("[world]\nname = 'staged'\n" + stop, "r.toml", worlds).value();
  };
  const auto text = extended_text(with(""), {.solutions = 9});
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(read_request(text.value(), "r.toml", worlds).value(), with("[stop]\ntakes = 9\n"));
  EXPECT_THAT(why_not(with(""), {.solutions = 5}), HasSubstr("already has takes = 5"));
}

TEST(Extension, IsLonger) {
  const DirectionRequest before = request_with("scans = 10\nindependent_solutions = 2");
  EXPECT_EQ(why_not(before, {}), "no stop rule is given");
  EXPECT_THAT(why_not(before, {.scans = 10}), HasSubstr("already has scans = 10"));
  EXPECT_THAT(why_not(before, {.scans = 20, .solutions = 1}),
              HasSubstr("already has independent_solutions = 2"));
  EXPECT_EQ(why_not(before, {.rounds = 1}), "");
}

// A rule's range is not checked when a request is extended, but when the extended text is read.
TEST(Extension, LeavesValuesToTheReader) {
  const auto text = extended_text(request_with("scans = 10"), {.scans = k_scans_max + 1});
  ASSERT_TRUE(text.ok());
  const std::array worlds{toy::binding()};
  EXPECT_FALSE(read_request(text.value(), "r.toml", worlds).ok());
}

}  // namespace sleight::request::extension_test
