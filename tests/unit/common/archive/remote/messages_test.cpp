// Goal: an archive's description stays equal when it is encoded and decoded. If a description is
// invalid, it is refused with a reason. Method: encode and decode descriptions. Cut or change the
// encoded bytes. Break one invariant of contents_check.h at a time.
#include "common/archive/remote/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/archive/digest/digest.h"
#include "common/archive/format.h"
#include "common/archive/limits.h"
#include "common/archive/remote/contents_check.h"
#include "tests/archive/memory_archive.h"
#include "tests/support/property.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::archive::remote {
namespace {

using archive::testing::mixed;
using ::testing::HasSubstr;

std::vector<Group> sample() {
  MemoryArchive archive;
  write_digested(archive, archive::testing::filler({.chains = 2, .scans = 20, .thin = 5}));
  return archive.groups();
}

void expect_same(const std::vector<Group>& a, const std::vector<Group>& b) {
  EXPECT_EQ(encode_contents(a), encode_contents(b));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ(a[i].datasets.size(), b[i].datasets.size());
  }
}

TEST(Messages, ContentsComeAcross) {
  const std::vector<Group> groups = sample();
  const auto back = decode_contents(encode_contents(groups));
  ASSERT_TRUE(back) << back.error();
  expect_same(groups, back.value());
  EXPECT_EQ(fault_of_contents(back.value()), "");
}

TEST(Messages, HeadsAndQuestionsComeAcross) {
  const Question question{.number = 7, .dataset = 3, .first = 1ULL << 40, .count = 5};
  EXPECT_EQ(decode_question(encode(question)), question);
  const AnswerHead head{
      .number = 7, .kind = AnswerKind::values, .type = 2, .nothing = 9, .bytes = 1ULL << 50};
  EXPECT_EQ(decode_head(encode(head)), head);
}

TEST(Messages, TextsComeAcross) {
  const std::vector<std::string> texts{"", "a", "12345678"};
  const base::Bytes bytes = encode_texts(texts);
  EXPECT_EQ(decode_texts(bytes, 3, 8).value(), texts);
  EXPECT_FALSE(decode_texts(bytes, 3, 7)) << "one is longer";
  EXPECT_FALSE(decode_texts(bytes, 2, 8)) << "bytes are left";
  EXPECT_FALSE(decode_texts(bytes, 4, 8)) << "one is missing";
  EXPECT_EQ(texts_bytes_max(~0ULL, 8), ~0ULL);
}

TEST(Messages, CutContentsAreRefused) {
  const base::Bytes bytes = encode_contents(sample());
  constexpr std::size_t k_step = 23;
  for (std::size_t size = 0; size < bytes.size(); size += k_step)
    EXPECT_FALSE(decode_contents(base::BytesView(bytes).first(size))) << size;
}

TEST(Messages, ChangedContentsAreJudgedWithoutHarm) {
  const base::Bytes whole = encode_contents(sample());
  int refused = 0;
  for (const std::uint64_t n :
       property::cases(property::long_run() ? 200'000 : property::of_tier(300, 2'000))) {
    base::Bytes bytes = whole;
    for (std::uint64_t i = 0; i < 1 + mixed(n) % 4; ++i)
      bytes[mixed(4 * n + i) % bytes.size()] = static_cast<std::byte>(mixed(n + 1000 * i));
    const auto groups = decode_contents(bytes);
    if (!groups || !fault_of_contents(groups.value()).empty()) ++refused;
  }
  if (property::all_cases()) {
    EXPECT_GT(refused, 0);
  }
}

std::string fault_after(const std::function<void(std::vector<Group>&)>& change) {
  std::vector<Group> groups = sample();
  change(groups);
  return fault_of_contents(groups);
}

Group& posterior(std::vector<Group>& groups) {
  for (Group& group : groups)
    if (group.name == k_posterior) return group;
  throw std::logic_error("no posterior");
}

TEST(Contents, GroupsThatCantBeAreNamed) {
  EXPECT_THAT(fault_of_contents({}), HasSubstr("root group is missing"));
  EXPECT_THAT(fault_after([](auto& g) { std::swap(g[0], g[1]); }),
              HasSubstr("root group is missing"));
  EXPECT_THAT(fault_after([](auto& g) { g[1].name = "/a/b"; }), HasSubstr("invalid name"));
  EXPECT_THAT(fault_after([](auto& g) { g[1].name = "a"; }), HasSubstr("invalid name"));
  EXPECT_THAT(fault_after([](auto& g) { g.push_back(g[1]); }), HasSubstr("occurs twice"));
  EXPECT_THAT(fault_after([](auto& g) { g[0].attributes.clear(); }), HasSubstr("format"));
  EXPECT_THAT(fault_after([](auto& g) {
                for (Attribute& attribute : g[0].attributes)
                  if (attribute.name == "format_version") attribute.value = k_format_version + 1;
              }),
              HasSubstr("format_version"));
}

TEST(Contents, AttributesThatCantBeAreNamed) {
  const auto with = [](const Attribute& attribute) {
    return fault_after([&](auto& g) { posterior(g).attributes.push_back(attribute); });
  };
  EXPECT_EQ(with({"mine", std::string("a text")}), "");
  EXPECT_EQ(with({"mine", std::numeric_limits<double>::quiet_NaN()}), "");
  EXPECT_THAT(with({"mine", std::string("\033[2J")}), HasSubstr("control characters"));
  EXPECT_THAT(with({"mine", std::string("two\nlines")}), HasSubstr("control characters"));
  EXPECT_THAT(with({"mine", std::string("\xff")}), HasSubstr("control characters"));
  EXPECT_THAT(with({"mine", std::string(k_attribute_bytes_max + 1, 'x')}), HasSubstr("too long"));
  EXPECT_THAT(with({"not\nmine", std::int64_t{1}}), HasSubstr("invalid name"));
  EXPECT_THAT(with({"thin", std::int64_t{1}}), HasSubstr("two attributes are named thin"));
  EXPECT_THAT(fault_after([](auto& g) {
                for (std::uint64_t i = 0; i <= k_attributes_max; ++i)
                  posterior(g).attributes.push_back({"a" + std::to_string(i), std::int64_t{0}});
              }),
              HasSubstr("too many attributes"));
}

TEST(Contents, DatasetsThatCantBeAreNamed) {
  const auto with = [](const DatasetSpec& spec) {
    return fault_after([&](auto& g) { posterior(g).datasets.push_back(spec); });
  };
  const auto self = [](std::size_t size) { return std::vector<Dimension>{{"mine", size}}; };
  EXPECT_EQ(with({.name = "mine", .dims = self(3)}), "");
  EXPECT_THAT(with({.name = "draw", .dims = self(3)}), HasSubstr("occurs twice"));
  EXPECT_THAT(with({.name = "..", .dims = self(3)}), HasSubstr("invalid name"));
  EXPECT_THAT(with({.name = "mine", .dims = {{"other", 3}}}), HasSubstr("has no scale"));
  EXPECT_THAT(with({.name = "mine", .dims = {{"a b", 3}}}), HasSubstr("invalid name"));
  EXPECT_THAT(with({.name = "mine", .dims = self(k_growing)}), HasSubstr("more than"));
  EXPECT_THAT(with({.name = "mine", .dims = self(k_dataset_bytes_max)}), HasSubstr("more than"));
  // 2^62 elements of 8 bytes have 2^65 bytes, which overflow to 0 in 64 bits.
  const std::size_t half = std::size_t{1} << 31;
  EXPECT_THAT(with({.name = "mine", .dims = {{"mine", half}, {"mine", half}}}),
              HasSubstr("more than"));
  EXPECT_THAT(with({.name = "mine", .dims = std::vector<Dimension>(20, {"mine", 1})}),
              HasSubstr("dimensions, found 20"));
  EXPECT_THAT(with({.name = "mine", .type = ElementType::text, .dims = self(3)}),
              HasSubstr("0 bytes"));
  EXPECT_THAT(with({.name = "mine", .dims = self(3), .text_bytes = 4}), HasSubstr("4 bytes"));
  EXPECT_THAT(fault_after([&](auto& g) {
                for (std::uint64_t i = 0; i <= k_objects_max; ++i)
                  posterior(g).datasets.push_back({.name = "d" + std::to_string(i)});
              }),
              HasSubstr("objects"));
}

TEST(Contents, ShownTextsSteerNoTerminal) {
  EXPECT_EQ(shown_text("the chunk of draw is damaged"), "the chunk of draw is damaged");
  EXPECT_EQ(shown_text("a\033[2J"), "a?[2J");
  EXPECT_LE(shown_text(std::string(100'000, 'x')).size(), 4096U);
  EXPECT_TRUE(is_text_for(k_root, k_request, "two\nlines\n"));
  EXPECT_FALSE(is_text_for(k_root, "other", "two\nlines\n"));
  EXPECT_FALSE(is_text_for(k_root, k_request, "\033[2J"));
}

}  // namespace
}  // namespace sleight::archive::remote
