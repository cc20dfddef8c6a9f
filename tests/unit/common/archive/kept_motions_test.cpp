// Goal: an archive returns scenes and motions as they were written, and reports damage as an error.
// Method: write archives of a made-up world. Read all values of a sound archive. Damage one value
// in each of the other archives.
#include "common/archive/kept_motions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/archive/digest/digest.h"
#include "common/archive/digest/verify.h"
#include "common/archive/format.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::archive {
namespace {

using ::testing::Contains;
using testing::FakeReader;
using testing::FakeRun;
using testing::FakeRunOptions;
using testing::filler;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

void write(MemoryArchive& archive) {
  FakeRunOptions options;
  options.finds = 5;
  write_digested(archive, filler(options));
}

TEST(KeptMotions, ComeBackAsTheyWereWritten) {
  FakeRunOptions options;
  options.finds = 5;
  MemoryArchive archive;
  write(archive);
  EXPECT_THAT(verify(archive), IsEmpty());
  const FakeReader reader;
  const auto scene = scene_of(archive);
  ASSERT_TRUE(scene.ok()) << scene.error();
  const scene::Scene& expected = reader.scene();
  ASSERT_EQ(scene.value().features.size(), expected.features.size());
  for (std::size_t i = 0; i < expected.features.size(); ++i) {
    EXPECT_EQ(scene.value().features[i].name, expected.features[i].name);
    EXPECT_EQ(scene.value().features[i].kind, expected.features[i].kind);
    EXPECT_EQ(scene.value().features[i].twin_of, expected.features[i].twin_of);
    EXPECT_EQ(scene.value().features[i].body, expected.features[i].body);
  }
  ASSERT_EQ(scene.value().parts.size(), expected.parts.size());
  for (std::size_t i = 0; i < expected.parts.size(); ++i) {
    EXPECT_EQ(scene.value().parts[i].feature, expected.parts[i].feature);
    EXPECT_EQ(scene.value().parts[i].shape, expected.parts[i].shape);
    EXPECT_EQ(scene.value().parts[i].size_m, expected.parts[i].size_m);
    EXPECT_EQ(scene.value().parts[i].triangles, expected.parts[i].triangles);
  }
  EXPECT_EQ(scene.value().triangles, expected.triangles);
  EXPECT_EQ(scene.value().high_m, expected.high_m);
  EXPECT_TRUE(scene.value().has_own_parts && scene.value().has_own_points);

  for (const std::string_view group : {k_animations, k_finds}) {
    const KeptMotions motions(archive, group);
    const FakeRun run(options);
    std::vector<plan::ScanRecord> records;
    if (group == k_finds) {
      run.for_each_find(
          [&](std::uint64_t, const plan::ScanRecord& record) { records.push_back(record); });
    } else {
      const auto chains = std::get<std::vector<std::int64_t>>(
          archive.read(k_animations, "chain", 0, motions.count()));
      const auto draws = std::get<std::vector<std::int64_t>>(
          archive.read(k_animations, "draw", 0, motions.count()));
      for (std::size_t i = 0; i < chains.size(); ++i)
        records.push_back(run.record({static_cast<std::uint32_t>(chains[i])},
                                     static_cast<std::uint64_t>(draws[i])));
    }
    ASSERT_EQ(motions.count(), records.size());
    std::size_t segments = 0;
    for (std::uint64_t i = 0; i < motions.count(); ++i) {
      const std::vector<motion::Segment> played = reader.play(records[i].state).segments;
      const auto animation = motions.animation(i, scene.value());
      ASSERT_TRUE(animation.ok()) << animation.error();
      EXPECT_EQ(animation.value().segment_count(), played.size());
      segments += played.size();
      std::vector<std::size_t> next(2, 0);
      for (motion::Segment segment : played) {
        segment.orientation = math::normalized(segment.orientation);
        EXPECT_TRUE(animation.value().path(segment.body).segments()[next[segment.body]++] ==
                    segment);
      }
      const auto own = motions.variation(i, scene.value());
      ASSERT_TRUE(own.ok()) << own.error();
      const scene::Variation written = reader.variation(records[i].state, played);
      EXPECT_EQ(own.value().points, written.points);
      EXPECT_EQ(own.value().parts.size(), written.parts.size());
      EXPECT_EQ(motions.in_proportion(i), group == k_animations);
      EXPECT_TRUE(motions.offsets_m(i, scene.value()).empty());
    }
    EXPECT_GT(segments, 4U);
  }
}

TEST(KeptMotions, DamageIsNamed) {
  const auto findings = [](const std::function<void(MemoryArchive&)>& damage) {
    MemoryArchive archive;
    write(archive);
    damage(archive);
    std::string all;
    for (const std::string& finding : verify(archive))
      all += finding + "\n";
    return all;
  };
  const auto small = [](MemoryArchive& archive, std::string_view group,
                        std::string_view name) -> std::vector<std::int32_t>& {
    return std::get<std::vector<std::int32_t>>(archive.values(group, name));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(findings([](MemoryArchive&) {}), "");
  for (const std::string_view group : {k_animations, k_finds}) {
    const auto says = [&](const std::function<void(MemoryArchive&)>& damage) {
      // Read every motion, because verify() checks rows only if everything else is sound, including
      // the digest.
      MemoryArchive archive;
      write(archive);
      damage(archive);
      const auto scene = scene_of(archive);
      if (!scene) return scene.error();
      const KeptMotions motions(archive, group);
      for (std::uint64_t i = 0; i < motions.count(); ++i) {
        const auto animation = motions.animation(i, scene.value());
        if (!animation) return animation.error();
        const auto own = motions.variation(i, scene.value());
        if (!own) return own.error();
      }
      return std::string("sound");
    };
    EXPECT_EQ(says([](MemoryArchive&) {}), "sound");
    EXPECT_THAT(says([&](MemoryArchive& a) { small(a, group, "body")[0] = 2; }),
                HasSubstr("moves body"));
    EXPECT_THAT(says([&](MemoryArchive& a) { small(a, group, "body")[0] = -1; }),
                HasSubstr("invalid segment"));
    EXPECT_THAT(says([&](MemoryArchive& a) { small(a, group, "mode")[0] = 4; }),
                HasSubstr("invalid segment"));
    // If 256 were cut to one byte, it would become 0, which is a valid mode.
    EXPECT_THAT(says([&](MemoryArchive& a) { small(a, group, "mode")[0] = 256; }),
                HasSubstr("invalid segment"));
    EXPECT_THAT(says([&](MemoryArchive& a) { small(a, group, "cause")[0] = 1; }),
                HasSubstr("invalid segment"));
    EXPECT_THAT(says([&](MemoryArchive& a) { small(a, group, "partner")[0] = 2; }),
                HasSubstr("invalid segment"));
    EXPECT_THAT(says([&](MemoryArchive& a) { small(a, group, "point_i")[0] = INT32_MIN; }),
                HasSubstr("control point"));
    EXPECT_THAT(says([&](MemoryArchive& a) {
                  std::get<std::vector<double>>(a.values(group, "point_height_m"))[0] = nan;
                }),
                HasSubstr("control point"));
    EXPECT_THAT(says([&](MemoryArchive& a) {
                  std::get<std::vector<std::int64_t>>(a.values(group, "segment_count"))[0] =
                      INT64_MAX;
                }),
                ::testing::AllOf(HasSubstr("rows along "), HasSubstr("are missing")));
  }
  EXPECT_THAT(findings([&](MemoryArchive& a) { small(a, k_scene, "part_shape")[0] = 77; }),
              HasSubstr("out of range"));
  EXPECT_THAT(findings([&](MemoryArchive& a) { small(a, k_scene, "triangle_vertex")[0] = 99; }),
              HasSubstr("content_digest"));
  EXPECT_THAT(findings([&](MemoryArchive& a) {
                std::get<std::vector<double>>(a.values(k_sample_stats_prior, "lp"))[3] = 1;
              }),
              HasSubstr("/sample_stats_prior/lp"));
}

}  // namespace
}  // namespace sleight::archive
