// Goal: exported files are sound glTF and match their documents. If a document is exported twice,
// both files have the same bytes. Hostile names and texts do no harm. Method: export small scenes,
// and read the files back with read_glb.h.
#include "clients/export/document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "tests/support/numbers.h"
#include "tests/unit/clients/export/read_glb.h"

namespace sleight::gltf {
namespace {

using math::Vec3;
using motion::Segment;
using scene::FeatureKind;
using scene::Shape;
using testing::File;
using ::testing::HasSubstr;
using namespace std::string_literals;
using testing::Json;

/// Returns a scene of two equal dice, a ball, a goal and a table. The table's height differs
/// between animations.
scene::Scene table_scene() {
  scene::Scene scene;
  scene.features = {{.name = "die 1"},
                    {.name = "die 2"},
                    {.name = "ball"},
                    {.name = "table", .kind = FeatureKind::fixed},
                    {.name = "goal 1", .kind = FeatureKind::wanted, .body = 0}};
  scene.parts = {{.feature = 0, .shape = Shape::die, .size_m = {0.02, 0.02, 0.02}},
                 {.feature = 1, .shape = Shape::die, .size_m = {0.02, 0.02, 0.02}},
                 {.feature = 2, .shape = Shape::sphere, .size_m = {0.03, 0.03, 0.03}},
                 {.feature = 4, .shape = Shape::disc, .size_m = {0.05, 0.05, 0}}};
  scene.has_own_parts = true;
  return scene;
}

motion::Animation animation_of(const std::vector<Segment>& segments, std::size_t bodies) {
  return motion::Animation::of(segments, bodies).value();
}

Clip clip_of(const std::string& name, double table_m, const std::vector<Segment>& segments) {
  return {.name = name,
          .motion = animation_of(segments, 3),
          .own = {.parts = {{.feature = 3,
                             .shape = Shape::ground,
                             .size_m = {1, 1, 0},
                             .position_m = {0, 0, table_m}}}},
          .extras = {{"id", name}, {"log_prior", -1.5}}};
}

/// Returns two clips. In the first clip, the ball enters late and the second die never enters. The
/// second clip has all bodies.
Document two_clips() {
  const Segment rest{.start_s = 1, .mode = motion::Mode::resting, .position_m = {0.5, 0, 0.4}};
  Segment ball = rest;
  ball.body = 2;
  ball.start_s = 0.25;
  Segment second = rest;
  second.body = 1;
  second.start_s = 0;
  Segment early_ball = ball;
  early_ball.start_s = 0;
  const Segment thrown{.position_m = {0, 0, 0.4}, .velocity_mps = {0.5, 0, 0}};
  return {.scene = table_scene(),
          .clips = {clip_of("c0.250", 0, {thrown, rest, ball}),
                    clip_of("c1.3", -0.01, {thrown, rest, second, early_ball})},
          .extras = {{"world", "dice"}}};
}

File file_of(const Document& document, const Options& options = {}) {
  const auto glb = glb_of(document, options);
  EXPECT_TRUE(glb.ok());
  File file = testing::read_glb(glb.value().bytes);
  testing::expect_sound(file);
  return file;
}

Document only(Document document, std::size_t clip) {
  document.clips = {document.clips[clip]};
  return document;
}

TEST(Document, HoldsBodiesSceneAndMotion) {
  const File file = file_of(only(two_clips(), 0));
  EXPECT_EQ(file.json["asset"]["generator"], "Sleight");
  EXPECT_EQ(file.json["asset"]["extras"], Json({{"world", "dice"}}));
  ASSERT_EQ(file.json["animations"].size(), 1U);
  EXPECT_EQ(file.json["animations"][0]["name"], "c0.250");
  EXPECT_EQ(file.json["animations"][0]["extras"], Json({{"id", "c0.250"}, {"log_prior", -1.5}}));
  ASSERT_EQ(file.json["nodes"].size(), 4U);
  EXPECT_FALSE(testing::has_node(file, "die 2")) << "it never enters";
  EXPECT_EQ(file.json["nodes"][testing::node_named(file, "table")]["extras"]["kind"], "fixed");
  EXPECT_EQ(file.json["nodes"][testing::node_named(file, "goal 1")]["extras"]["kind"], "wanted");

  const std::size_t die = testing::node_named(file, "die 1");
  const auto places = testing::track_of(file, 0, die, "translation");
  EXPECT_EQ(places.interpolation, "LINEAR");
  EXPECT_LT(math::norm(Vec3(testing::z_up(testing::played(places, 0.5)) - Vec3(0.25, 0, 0.4))),
            1e-6);
  EXPECT_TRUE(testing::track_of(file, 0, die, "scale").times_s.empty());
  const auto scale = testing::track_of(file, 0, testing::node_named(file, "ball"), "scale");
  EXPECT_EQ(scale.interpolation, "STEP");
  EXPECT_EQ(testing::played(scale, 0.24), (std::vector<double>{0, 0, 0}));
  EXPECT_EQ(testing::played(scale, 0.25), (std::vector<double>{1, 1, 1}));
}

TEST(Document, HoldsClipsTogether) {
  const File file = file_of(two_clips());
  ASSERT_EQ(file.json["animations"].size(), 2U);
  // Equal dice share a mesh. The table has one node for each animation.
  EXPECT_EQ(file.json["nodes"][testing::node_named(file, "die 1")]["mesh"],
            file.json["nodes"][testing::node_named(file, "die 2")]["mesh"]);
  EXPECT_FALSE(testing::has_node(file, "table"));
  const std::vector<double> there{1, 1, 1};
  const std::vector<double> away{0, 0, 0};
  const auto shown = [&](const std::string& name, std::size_t clip, double t_s) {
    const std::size_t node = testing::node_named(file, name);
    return testing::played(testing::track_of(file, clip, node, "scale"), t_s);
  };
  EXPECT_EQ(shown("table (c0.250)", 0, 0.5), there);
  EXPECT_EQ(shown("table (c0.250)", 1, 0.5), away);
  EXPECT_EQ(shown("table (c1.3)", 0, 0.5), away);
  EXPECT_EQ(shown("table (c1.3)", 1, 0.5), there);
  EXPECT_EQ(shown("die 2", 0, 0.5), away);
  EXPECT_EQ(shown("die 2", 1, 0.5), there);
  EXPECT_EQ(shown("ball", 0, 0.1), away);
  EXPECT_EQ(shown("ball", 1, 0.1), there);
  EXPECT_EQ(file.json["nodes"][testing::node_named(file, "table (c1.3)")]["scale"],
            Json({0, 0, 0}));
  EXPECT_TRUE(
      testing::track_of(file, 0, testing::node_named(file, "goal 1"), "scale").times_s.empty());
}

TEST(Document, IsTheSameBytesEachTime) {
  for (const Options& options : {Options{}, Options{.fps = 24}}) {
    const auto first = glb_of(two_clips(), options);
    EXPECT_EQ(first.value().bytes, glb_of(two_clips(), options).value().bytes);
    EXPECT_NE(first.value().bytes, glb_of(only(two_clips(), 0), options).value().bytes);
  }
  EXPECT_NE(glb_of(two_clips()).value().bytes, glb_of(two_clips(), {.fps = 24}).value().bytes);
  const File frames = file_of(two_clips(), {.fps = 24});
  const auto track =
      testing::track_of(frames, 0, testing::node_named(frames, "die 1"), "translation");
  EXPECT_EQ(track.times_s.size(), 25U);
}

TEST(Document, MakesNamesAndTextsHarmless) {
  Document document = only(two_clips(), 0);
  document.scene.features[0].name = "a \"die\" \\ \x1b[31m\xff \xC3\xA9";
  document.clips[0].name = "0.1\n\x07";
  document.extras = {{"request", "a = \"\xE2\x82\xAC\"\n\x1b]0;\x07\0b"s},
                     {"key\x1b", std::string("\xF0\x28")}};
  document.clips[0].extras = {{"log_prior", k_nan},
                              {"log_constraint", -std::numeric_limits<double>::infinity()},
                              {"draw", std::int64_t{9007199254740993}},
                              {"found", true},
                              {"face", std::vector<double>{1, k_nan, 6}}};
  const auto glb = glb_of(document);
  const File file = testing::read_glb(glb.value().bytes);
  testing::expect_sound(file);
  for (const char byte : file.text)
    EXPECT_TRUE(byte >= ' ' && byte <= '~') << static_cast<int>(byte);
  EXPECT_TRUE(testing::has_node(file, "a \"die\" \\ \uFFFD[31m\uFFFD \u00E9"));
  EXPECT_EQ(file.json["animations"][0]["name"], "0.1 \uFFFD");
  EXPECT_EQ(file.json["asset"]["extras"]["request"], "a = \"\u20AC\"\n\uFFFD]0;\uFFFD\uFFFDb");
  EXPECT_TRUE(file.json["asset"]["extras"].contains("key\uFFFD"));
  const Json& extras = file.json["animations"][0]["extras"];
  EXPECT_TRUE(extras["log_prior"].is_null());
  EXPECT_TRUE(extras["log_constraint"].is_null());
  EXPECT_EQ(extras["draw"], 9007199254740993);
  EXPECT_EQ(extras["found"], true);
  EXPECT_EQ(extras["face"], Json({1.0, nullptr, 6.0}));
}

TEST(Document, OfNothingThatMovesIsAFileToo) {
  // No body enters, but glTF requires a channel in each clip.
  Document document = only(two_clips(), 0);
  document.clips[0].motion = animation_of({}, 3);
  const File file = file_of(document);
  EXPECT_FALSE(testing::has_node(file, "die 1"));
  EXPECT_TRUE(testing::has_node(file, "table"));
  EXPECT_EQ(file.json["animations"][0]["channels"].size(), 1U);
  const File bare = file_of({.clips = {{.name = "c0.0", .motion = animation_of({}, 0)}}});
  EXPECT_EQ(bare.json["nodes"].size(), 1U);
}

TEST(Document, HoldsAHundredBodies) {
  Document document;
  std::vector<Segment> segments;
  for (std::uint32_t body = 0; body < 100; ++body) {
    document.scene.features.push_back({.name = fmt::format("ball {}", body + 1)});
    document.scene.parts.push_back(
        {.feature = body, .shape = Shape::sphere, .size_m = {0.016, 0.016, 0.016}});
    const double drop_s = 0.05 * body;
    const double z_m = 0.02 * body;
    segments.push_back({.body = body,
                        .start_s = drop_s,
                        .position_m = {0, 0.5, z_m},
                        .velocity_mps = {0.5, 0, 0},
                        .acceleration_mps2 = {0, 0, -9.81}});
    segments.push_back({.body = body,
                        .start_s = drop_s + 0.3,
                        .mode = motion::Mode::resting,
                        .position_m = {0.15, 0.5, z_m - 0.5 * 9.81 * 0.09}});
  }
  document.clips = {{.name = "c0.0", .motion = animation_of(segments, 100)}};
  const File file = file_of(document);
  EXPECT_EQ(file.json["nodes"].size(), 100U);
  for (std::uint32_t body = 0; body < 100; ++body) {
    const std::size_t node = testing::node_named(file, fmt::format("ball {}", body + 1));
    const auto places = testing::track_of(file, 0, node, "translation");
    for (int tenth = 0; tenth <= 10; ++tenth) {
      const double t_s = 0.05 * body + 0.001 + 0.032 * tenth;
      const Vec3 true_m = *document.clips[0].motion.path(body).centre_at(t_s);
      EXPECT_LT(math::norm(Vec3(testing::z_up(testing::played(places, t_s)) - true_m)), 1e-4);
    }
  }
  // If two balls have different colours, they have different meshes, but the meshes share their
  // vertices.
  EXPECT_EQ(file.json["meshes"].size(), 100U);
  EXPECT_EQ(file.json["meshes"][0]["primitives"][0]["attributes"],
            file.json["meshes"][99]["primitives"][0]["attributes"]);
}

TEST(Document, SaysWhyThereIsNone) {
  Document document = only(two_clips(), 0);
  document.clips[0].motion = animation_of(
      {{.angular_velocity_radps = {1e8, 0, 0}}, {.start_s = 1e4, .mode = motion::Mode::resting}},
      3);
  const auto glb = glb_of(document);
  ASSERT_FALSE(glb.ok());
  EXPECT_THAT(glb.error(), HasSubstr("keys"));

  // If each of n clips has its own table, the number of channels grows as n^2.
  document = only(two_clips(), 0);
  const Clip clip = document.clips[0];
  document.clips.clear();
  for (int i = 0; i < 510; ++i) {
    document.clips.push_back(clip);
    document.clips.back().own.parts[0].position_m.z() = 1e-3 * i;
  }
  EXPECT_THAT(glb_of(document).error(), HasSubstr("export fewer animations together"));
}

}  // namespace
}  // namespace sleight::gltf
