// Goal: an outline is an index without motions, and reads back from its bytes.
#include "clients/browse/outline.h"

#include <gtest/gtest.h>

#include "tests/unit/clients/browse/random_index.h"

namespace sleight::browse {
namespace {

Outline outline_of_many() {
  random::Stream stream = testing::stream_of(5, 0);
  const Index index = testing::random_index(40, stream);
  Groups groups{.is_approximate = true};
  for (std::size_t group = 0; group < 3; ++group) {
    AlikeGroup& made = groups.groups.emplace_back();
    made.representative = 10 * group;
    made.members = {10 * group, 10 * group + 3, 39};
    made.mean_m = 0.25 * static_cast<double>(group);
    made.greatest_m = 1.5;
  }
  return outline_of(index, groups);
}

TEST(Outline, IsTheIndexWithoutMotions) {
  // Goal: an outline's entries equal the index's entries except for their motions. Method: delete
  // the motions from a random index, and compare it with its outline.
  random::Stream stream = testing::stream_of(5, 0);
  const Index index = testing::random_index(40, stream);
  const Outline outline = outline_of_many();
  ASSERT_EQ(outline.index.entries.size(), index.entries.size());
  EXPECT_EQ(outline.index.run_id, index.run_id);
  EXPECT_EQ(outline.index.digest, index.digest);
  EXPECT_EQ(outline.index.numbers, index.numbers);
  for (std::size_t i = 0; i < index.entries.size(); ++i) {
    Entry still = index.entries[i];
    EXPECT_FALSE(still.pieces.empty());
    still.tracks.assign(still.tracks.size(), {});
    still.pieces.clear();
    still.contacts.clear();
    EXPECT_EQ(outline.index.entries[i], still);
  }
}

TEST(Outline, ComesBackFromItsBytesOrNotAtAll) {
  // Goal: the bytes of an outline read back as an equal outline. Damaged bytes and bytes of another
  // version are rejected. Method: truncate the bytes and flip bits. Name missing entries in groups,
  // with a valid checksum.
  const Outline outline = outline_of_many();
  const base::Bytes bytes = bytes_of(outline, "1.2");
  const auto back = outline_of_bytes(bytes, "1.2");
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(bytes_of(*back, "1.2"), bytes);
  ASSERT_EQ(back->groups.groups.size(), 3U);
  EXPECT_TRUE(back->groups.is_approximate);
  for (std::size_t group = 0; group < 3; ++group) {
    EXPECT_EQ(back->groups.groups[group].representative, 10 * group);
    EXPECT_EQ(back->groups.groups[group].members, outline.groups.groups[group].members);
    EXPECT_EQ(back->groups.groups[group].mean_m, outline.groups.groups[group].mean_m);
  }
  EXPECT_FALSE(outline_of_bytes(bytes, "1.3").has_value());
  EXPECT_FALSE(outline_of_bytes(bytes, "").has_value());
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 16)
    EXPECT_FALSE(outline_of_bytes(base::BytesView(bytes).first(size), "1.2").has_value()) << size;
  for (std::size_t at = 0; at < bytes.size(); at += 1 + at / 16) {
    base::Bytes changed = bytes;
    changed[at] ^= std::byte{4};
    EXPECT_FALSE(outline_of_bytes(changed, "1.2").has_value()) << at;
  }
  Outline wrong = outline;
  wrong.groups.groups[1].members[2] = 40;
  EXPECT_FALSE(outline_of_bytes(bytes_of(wrong, "1.2"), "1.2").has_value());
  wrong = outline;
  wrong.groups.groups[2].representative = 40;
  EXPECT_FALSE(outline_of_bytes(bytes_of(wrong, "1.2"), "1.2").has_value());
}

}  // namespace
}  // namespace sleight::browse
