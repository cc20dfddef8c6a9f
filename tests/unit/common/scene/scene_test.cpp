// Goal: a sound scene is accepted. If a scene is unsound, the error names its fault. Method: break
// one property of a sound scene at a time.
#include "common/scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace sleight::scene {
namespace {

using ::testing::HasSubstr;

Scene sound() {
  return {.features = {{.name = "die 1", .twin_of = 0},
                       {.name = "die 2", .twin_of = 0},
                       {.name = "table", .kind = FeatureKind::fixed, .twin_of = 2},
                       {.name = "place", .kind = FeatureKind::wanted, .twin_of = 3, .body = 1}},
          .parts = {{.feature = 0, .shape = Shape::die, .size_m = {1, 1, 1}},
                    {.feature = 2, .shape = Shape::mesh, .triangles = 1}},
          .vertices = {{.place_m = {0, 0, 0}, .offset = 0}, {.place_m = {1, 0, 0}}, {}},
          .triangles = {{0, 1, 2}},
          .offset_variable = "vertex_offset_m"};
}

TEST(Scene, IsSoundOrSaysWhatIsWrong) {
  EXPECT_EQ(fault_of(sound()), "");
  EXPECT_EQ(fault_of(Scene{}), "");
  EXPECT_EQ(sound().bodies(), 2U);
  EXPECT_EQ(sound().find("table"), 2U);
  EXPECT_FALSE(sound().find("Table"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto fault = [](const std::function<void(Scene&)>& change) {
    Scene scene = sound();
    change(scene);
    return fault_of(scene);
  };
  EXPECT_THAT(fault([](Scene& s) { s.features[1].name = ""; }), HasSubstr("no name"));
  EXPECT_THAT(fault([](Scene& s) { s.features[1].name = "die 1"; }), HasSubstr("two features"));
  EXPECT_THAT(fault([](Scene& s) { s.features[3].kind = FeatureKind::body; }),
              HasSubstr("not ordered by kind"));
  EXPECT_THAT(fault([](Scene& s) { s.features[0].twin_of = 1; }), HasSubstr("not a twin"));
  EXPECT_THAT(fault([](Scene& s) { s.features[2].twin_of = 0; }), HasSubstr("not a twin"));
  EXPECT_THAT(fault([](Scene& s) { s.features[3].body = 2; }), HasSubstr("invalid body"));
  EXPECT_THAT(fault([](Scene& s) { s.features[2].body = 0; }), HasSubstr("invalid body"));
  EXPECT_THAT(fault([](Scene& s) { s.parts[0].feature = 3; }),
              HasSubstr("order of their features"));
  EXPECT_THAT(fault([](Scene& s) { s.parts[1].feature = 4; }),
              HasSubstr("order of their features"));
  EXPECT_THAT(fault([&](Scene& s) { s.parts[0].size_m.x() = nan; }), HasSubstr("invalid numbers"));
  EXPECT_THAT(fault([](Scene& s) { s.parts[0].size_m.x() = -1; }), HasSubstr("invalid numbers"));
  EXPECT_THAT(fault([](Scene& s) { s.parts[0].orientation.w() = 0; }),
              HasSubstr("invalid numbers"));
  EXPECT_THAT(fault([](Scene& s) { s.parts[1].triangles = 2; }), HasSubstr("missing triangles"));
  EXPECT_THAT(fault([](Scene& s) { s.parts[1].first_triangle = UINT32_MAX; }),
              HasSubstr("missing triangles"));
  EXPECT_THAT(fault([](Scene& s) { s.parts[0].triangles = 1; }), HasSubstr("missing triangles"));
  EXPECT_THAT(fault([](Scene& s) { s.triangles[0][2] = 3; }), HasSubstr("missing vertex"));
  EXPECT_THAT(fault([&](Scene& s) { s.vertices[1].place_m.y() = nan; }),
              HasSubstr("a vertex has invalid numbers"));
  EXPECT_THAT(fault([](Scene& s) { s.offset_variable = ""; }),
              HasSubstr("offset_variable is missing"));
  EXPECT_THAT(fault([](Scene& s) { s.low_m.x() = 1; }), HasSubstr("view box"));
}

}  // namespace
}  // namespace sleight::scene
