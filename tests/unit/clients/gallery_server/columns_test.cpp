// Goal: a packed answer contains each column bit for bit, at the place where the page expects it.
// Method: unpack the answers, and compare the columns with the motions in an archive of the made-up
// world.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "clients/gallery_server/meshes.h"
#include "clients/gallery_server/packed.h"
#include "clients/gallery_server/recording.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/clients/gallery_server/made_up.h"
#include "tests/unit/clients/gallery_server/unpack.h"

namespace sleight::gallery {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::made_up;
using testing::Unpacked;
using testing::unpacked;

TEST(PackedAnswer, GivesBackItsColumns) {
  // Goal: columns of all types read back, including odd lengths, an empty column and NaN. Invalid
  // UTF-8 in a text is replaced.
  Packed packed;
  packed.add("d", std::vector<double>{1.5, std::numeric_limits<double>::quiet_NaN(), -0.0});
  packed.add("f", std::vector<float>{0.25F});
  packed.add("u", std::vector<std::uint32_t>{1, 4'000'000'000U, 3});
  packed.add("i", std::vector<std::int32_t>{-1});
  packed.add("b", std::vector<std::uint8_t>{1, 0, 1, 1, 0});
  packed.add("none", std::vector<double>{});
  const std::string whole = packed.finish({{"name", "\"ä\" \xff </script>"}});
  const Unpacked back = unpacked(whole);
  EXPECT_EQ(back.head["name"], "\"ä\" \xEF\xBF\xBD </script>");
  const auto doubles = back.column<double>("d");
  EXPECT_EQ(doubles[0], 1.5);
  EXPECT_TRUE(std::isnan(doubles[1]));
  EXPECT_TRUE(std::signbit(doubles[2]));
  EXPECT_THAT(back.column<float>("f"), ElementsAre(0.25F));
  EXPECT_THAT(back.column<std::uint32_t>("u"), ElementsAre(1, 4'000'000'000U, 3));
  EXPECT_THAT(back.column<std::int32_t>("i"), ElementsAre(-1));
  EXPECT_THAT(back.column<std::uint8_t>("b"), ElementsAre(1, 0, 1, 1, 0));
  EXPECT_THAT(back.column<double>("none"), IsEmpty());
}

TEST(Columns, HoldEachSegment) {
  // Goal: an animation's columns contain all its segments.
  const archive::MemoryArchive memory = made_up(101, 3);
  const auto scene = archive::scene_of(memory);
  ASSERT_TRUE(scene.ok());
  for (const std::string_view group : {archive::k_animations, archive::k_finds}) {
    const archive::KeptMotions motions(memory, group);
    for (std::uint64_t nth = 0; nth < motions.count(); ++nth) {
      const browse::KeptAnimation animation =
          browse::kept_animation(memory, motions, nth, scene.value(), "it");
      Packed packed;
      const auto head = add_animation(packed, "3:", "it", animation, scene.value());
      const std::string whole = packed.finish(head);
      const Unpacked back = unpacked(whole);
      EXPECT_EQ(back.head["columns"], "3:");
      EXPECT_EQ(back.head["end_s"], animation.motion.end_s());
      const auto body = back.column<std::uint32_t>("3:body");
      const auto start_s = back.column<double>("3:start_s");
      const auto velocity = back.column<double>("3:velocity_mps");
      const auto orientation = back.column<double>("3:orientation");
      const auto partner = back.column<std::int32_t>("3:partner");
      ASSERT_EQ(body.size(), animation.motion.segment_count());
      std::size_t row = 0;
      for (const motion::Path& path : animation.motion.paths()) {
        for (const motion::Segment& segment : path.segments()) {
          EXPECT_EQ(body[row], segment.body);
          EXPECT_EQ(start_s[row], segment.start_s);
          EXPECT_EQ(velocity[3 * row + 2], segment.velocity_mps.z());
          EXPECT_EQ(orientation[4 * row], segment.orientation.w());
          EXPECT_EQ(orientation[4 * row + 3], segment.orientation.z());
          EXPECT_EQ(partner[row], segment.partner);
          ++row;
        }
      }
      for (const json::Value& mesh : back.head["meshes"].elements()) {
        const auto places = back.column<float>(mesh["places"].get<std::string>());
        EXPECT_EQ(places.size(), back.column<float>(mesh["normals"].get<std::string>()).size());
        for (const std::uint32_t corner :
             back.column<std::uint32_t>(mesh["corners"].get<std::string>()))
          ASSERT_LT(3 * corner, places.size());
      }
    }
  }
}

TEST(Columns, FeaturesAreAllCommonOrAnAnimationsOwn) {
  // Goal: each feature of a scene belongs either to all animations or to one animation.
  const archive::MemoryArchive memory = made_up(101, 3);
  const auto scene = archive::scene_of(memory);
  ASSERT_TRUE(scene.ok());
  std::vector<std::uint32_t> all = common_features(scene.value());
  const std::vector<std::uint32_t> own = own_features(scene.value());
  EXPECT_FALSE(own.empty());
  EXPECT_FALSE(all.empty());
  all.insert(all.end(), own.begin(), own.end());
  std::ranges::sort(all);
  ASSERT_EQ(all.size(), scene.value().features.size());
  for (std::uint32_t feature = 0; feature < all.size(); ++feature)
    EXPECT_EQ(all[feature], feature);
}

}  // namespace
}  // namespace sleight::gallery
