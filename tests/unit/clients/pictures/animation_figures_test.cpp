// Goal: pictures of any world's animations show bodies and goals at their places and inside the
// panel. Method: draw few bodies and many bodies. Count and measure the drawn shapes.
#include "clients/pictures/animation_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "clients/plot/layout.h"
#include "clients/plot/svg.h"
#include "common/archive/digest/digest.h"
#include "common/base/error.h"
#include "tests/archive/memory_archive.h"
#include "tests/archive/small_archive.h"
#include "tests/support/facts.h"
#include "tests/support/refusals.h"
#include "tests/unit/clients/pictures/panel_series.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::pictures {
namespace {

using scene::FeatureKind;
using scene::Shape;
using ::testing::HasSubstr;

/// Two dice over a surface. The goal of the first die is a disc.
scene::Scene dice_scene() {
  return {.features = {{.name = "die 1", .twin_of = 0},
                       {.name = "die 2", .twin_of = 1},
                       {.name = "table", .kind = FeatureKind::fixed, .twin_of = 2},
                       {.name = "goal 1", .kind = FeatureKind::wanted, .twin_of = 3, .body = 0}},
          .parts = {{.feature = 0, .shape = Shape::die, .size_m = {0.016, 0.016, 0.016}},
                    {.feature = 1, .shape = Shape::die, .size_m = {0.016, 0.016, 0.016}},
                    {.feature = 2, .shape = Shape::surface, .size_m = {1, 1, 0.021}},
                    {.feature = 3,
                     .shape = Shape::disc,
                     .size_m = {0.01, 0.01, 0},
                     .position_m = {0.05, 0.003, 0}}},
          .has_own_points = true};
}

/// Die 1 flies for half a second and rests at (50, 0) mm. Die 1 makes a quarter turn about y, so
/// its face 6 is up. Die 2 rests at (0, y), and its face 3 is up.
ShownAnimation throw_of(double y_m = 0.04) {
  const double half_root = std::sqrt(0.5);
  const std::vector<motion::Segment> segments{
      {.body = 0,
       .position_m = {0, 0, 0.1},
       .velocity_mps = {0.1, 0, 0},
       .acceleration_mps2 = {0, 0, -0.8},
       .angular_velocity_radps = {0, M_PI, 0}},
      {.body = 0,
       .start_s = 0.5,
       .mode = motion::Mode::resting,
       .position_m = {0.05, 0, 0.008},
       .orientation = {half_root, 0, half_root, 0}},
      {.body = 1, .start_s = 0.1, .mode = motion::Mode::resting, .position_m = {0, y_m, 0.008}}};
  return {.title = "chain 1, scan 3", .motion = motion::Animation::of(segments, 2).value()};
}

scene::Scene box_scene(std::uint32_t balls) {
  scene::Scene scene;
  for (std::uint32_t ball = 0; ball < balls; ++ball) {
    scene.features.push_back({.name = "ball " + std::to_string(ball + 1), .twin_of = 0});
    scene.parts.push_back(
        {.feature = ball, .shape = Shape::sphere, .size_m = {0.016, 0.016, 0.016}});
  }
  scene.features.push_back({.name = "floor", .kind = FeatureKind::fixed, .twin_of = balls});
  scene.parts.push_back({.feature = balls, .shape = Shape::mesh, .triangles = 2});
  scene.vertices = {{.place_m = {-0.1, -0.05, 0}},
                    {.place_m = {0.1, -0.05, 0}},
                    {.place_m = {0.1, 0.05, 0}},
                    {.place_m = {-0.1, 0.05, 0}}};
  scene.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.features.push_back({.name = "bin", .kind = FeatureKind::wanted, .twin_of = balls + 1});
  scene.parts.push_back({.feature = balls + 1,
                         .shape = Shape::box,
                         .size_m = {0.02, 0.02, 0},
                         .position_m = {0.03, 0.01, 0}});
  return scene;
}

ShownAnimation drops(std::uint32_t balls) {
  std::vector<motion::Segment> segments;
  for (std::uint32_t ball = 0; ball < balls; ++ball) {
    const double x_m = -0.07 + 0.02 * ball;
    const double start_s = 0.15 * ball;
    segments.push_back({.body = ball,
                        .start_s = start_s,
                        .position_m = {x_m, 0, 0.08},
                        .acceleration_mps2 = {0, 0, -9.81}});
    segments.push_back({.body = ball,
                        .start_s = start_s + std::sqrt(2 * 0.072 / 9.81),
                        .mode = motion::Mode::resting,
                        .position_m = {x_m, 0, 0.008}});
  }
  return {.title = "chain 0, scan 1", .motion = motion::Animation::of(segments, balls).value()};
}

std::vector<plot::Polygon> squares_of(const plot::Panel& panel) {
  std::vector<plot::Polygon> squares;
  for (const plot::Polygon& polygon : all_of<plot::Polygon>(panel)) {
    if (polygon.corners.size() == 4) squares.push_back(polygon);
  }
  return squares;
}

TEST(AnimationFigures, ShowBodiesAtRestFromAbove) {
  // Goal: each die is drawn where it rests and shows the pips of its upper face. A ring marks the
  // goal. Method: draw only the view from above, which is in millimetres.
  const plot::Figure figure = animation_figure("dice", dice_scene(), {throw_of()}, false);
  ASSERT_EQ(figure.panels.size(), 1U);
  const plot::Panel& panel = figure.panels.front();
  EXPECT_THAT(panel.title, tests::HasFacts("chain 1, scan 3|6, 3|3.0 mm|0.50 s"));
  EXPECT_EQ(all_of<plot::Polygon>(panel).size(), 2U + 6 + 3);
  const auto squares = squares_of(panel);
  ASSERT_EQ(squares.size(), 2U);
  const auto is_first = [](const plot::Polygon& square) { return square.corners[0].x > 30; };
  const auto first = std::ranges::find_if(squares, is_first);
  ASSERT_NE(first, squares.end());
  for (const plot::Point& corner : first->corners) {
    EXPECT_NEAR(std::abs(corner.x - 50), 8, 1e-9);
    EXPECT_NEAR(std::abs(corner.y), 8, 1e-9);
  }
  const auto rings = all_of<plot::Disc>(panel);
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_NEAR(rings[0].center.x, 50, 1e-12);
  EXPECT_NEAR(rings[0].center.y, 3, 1e-12);
  EXPECT_DOUBLE_EQ(rings[0].radius_x, 5);
  // Die 1 moves at 0.1 m/s, and its centre is marked every sixtieth of a second.
  const auto centres = all_of<plot::Markers>(panel);
  ASSERT_EQ(centres.size(), 2U);
  ASSERT_GE(centres[0].points.size(), 30U);
  EXPECT_NEAR(centres[0].points[3].x - centres[0].points[2].x, 100.0 / 60, 1e-9);
}

TEST(AnimationFigures, PatchesAreShadedByTheirHeights) {
  // Goal: a table with control points is drawn darker where it is lower. Method: draw a sloping
  // table.
  ShownAnimation animation = throw_of();
  for (std::int32_t j = -1; j <= 2; ++j) {
    for (std::int32_t i = -1; i <= 3; ++i)
      animation.own.points.push_back({.i = i, .j = j, .height_m = 0.001 * i});
  }
  const plot::Figure figure = animation_figure("dice", dice_scene(), {animation}, false);
  std::vector<plot::Rectangle> patches;
  for (const auto& rectangle : all_of<plot::Rectangle>(figure.panels.front())) {
    if (rectangle.filled && rectangle.high.x - rectangle.low.x < 22) patches.push_back(rectangle);
  }
  ASSERT_EQ(patches.size(), 2U);
  EXPECT_LT(patches[0].low.x, patches[1].low.x);
  EXPECT_LT(patches[0].color.red, patches[1].color.red);
}

TEST(AnimationFigures, ManyBodiesAreShownAtInstants) {
  // Goal: many bodies are drawn where they rest, and eight frames show more and more of them.
  // Method: count the filled discs and the captions for eight balls.
  const scene::Scene scene = box_scene(8);
  const plot::Figure above = animation_figure("balls", scene, {drops(8)}, false);
  std::vector<plot::Point> centres;
  for (const plot::Disc& disc : all_of<plot::Disc>(above.panels.front())) {
    if (disc.filled) centres.push_back(disc.center);
  }
  ASSERT_EQ(centres.size(), 8U);
  EXPECT_NEAR(centres[3].x, -10, 1e-9);
  const plot::Figure figure = animation_figure("balls", scene, {drops(8), drops(8)});
  ASSERT_EQ(figure.panels.size(), 2U);
  std::size_t captions = 0;
  for (const plot::Text& text : all_of<plot::Text>(figure.panels.front()))
    captions += text.text.ends_with(" s") || text.text.ends_with("at rest") ? 1U : 0U;
  EXPECT_EQ(captions, 8U);
  std::size_t filled = 0;
  for (const plot::Disc& disc : all_of<plot::Disc>(figure.panels.front()))
    filled += disc.filled ? 1 : 0;
  EXPECT_GT(filled, 8U + 8 + 1);
  EXPECT_LT(filled, 8U + 8 * 8);
}

TEST(AnimationFigures, FitTheirPanels) {
  // Goal: nothing is cut off, animations are side by side, and a panel's units are pixels. Method:
  // draw scenes of different depths, with one to three animations each. Check that all shapes are
  // inside the panel, and that the layout's frame has the panel's size.
  for (const double y_m : {0.0, 0.04, 0.4, 4.0}) {
    for (const std::size_t count : {1U, 2U, 3U}) {
      const plot::Figure figure =
          animation_figure("dice", dice_scene(), std::vector<ShownAnimation>(count, throw_of(y_m)));
      ASSERT_EQ(figure.panels.size(), count);
      const plot::Panel& panel = figure.panels.front();
      const auto inside = [&](const plot::Point& point) {
        return point.x >= -1e-9 && point.y >= -1e-9 && point.x <= panel.x_range->high + 1e-9 &&
               point.y <= panel.y_range->high + 1e-9;
      };
      for (const plot::Polygon& polygon : all_of<plot::Polygon>(panel))
        ASSERT_TRUE(std::ranges::all_of(polygon.corners, inside));
      for (const plot::Line& line : all_of<plot::Line>(panel))
        ASSERT_TRUE(std::ranges::all_of(line.points, inside));
      const plot::PanelLayout layout = plot::layout_of(figure).panels.front();
      EXPECT_NEAR(layout.frame.width, panel.x_range->high, 0.01);
      EXPECT_NEAR(layout.frame.height, panel.y_range->high, 0.01);
      EXPECT_EQ(plot::to_svg(figure).find("nan"), std::string::npos);
    }
  }
}

class MovingReader final : public archive::testing::FakeReader {
 public:
  archive::Motion play(base::BytesView state) const override {
    archive::Motion motion = FakeReader::play(state);
    if (motion.segments.empty()) motion.segments.push_back({.position_m = {0.1, 0.2, 0.3}});
    return motion;
  }
};

TEST(AnimationFigures, AreDrawnFromAnArchiveAlone) {
  // Goal: if a world is unknown, its animations are drawn from the archive alone. If an animation
  // has no motion, it is refused. Method: draw the made-up world of the archive's tests.
  const archive::testing::FakeRunOptions options;
  archive::ArchiveOptions archive_options = archive::testing::options_for(options);
  archive_options.request_text = "[world]\nname = \"fake\"\n[sampler]\nchains = 3\n";
  const auto write = [&](const archive::StateReader& reader, archive::MemoryArchive& made) {
    archive::write_digested(made, [&](archive::Sink& sink) {
      archive::write_archive(archive::testing::FakeRun(options), reader, archive_options, sink);
    });
  };
  archive::MemoryArchive moving;
  write(MovingReader(), moving);
  const plot::Figure figure = animation_figure(moving, {.count = 12});
  EXPECT_EQ(figure.panels.size(), 12U);
  EXPECT_EQ(figure.title, "fake: 12 animations");
  EXPECT_EQ(plot::to_svg(figure).find("nan"), std::string::npos);
  archive::MemoryArchive still;
  write(archive::testing::FakeReader(), still);
  EXPECT_EQ(tests::failure_of([&] { animation_figure(still, {.count = 100}); }, "has no motion"),
            base::ExitCode::bad_archive);
}

}  // namespace
}  // namespace sleight::pictures
