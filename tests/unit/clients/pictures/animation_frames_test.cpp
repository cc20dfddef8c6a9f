// Goal: a film's frames show bodies where their motion puts them. Bodies are not cut off, and all
// frames have the same scale. Files are complete or absent. Method: measure frames of made-up
// motions. Write frames into folders. Run scripts in place of ffmpeg. If ffmpeg is installed, run
// it too.
#include "clients/pictures/animation_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "clients/pictures/ffmpeg.h"
#include "clients/plot/film.h"
#include "clients/plot/svg.h"
#include "common/base/error.h"
#include "tests/support/refusals.h"
#include "tests/unit/clients/pictures/panel_series.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::pictures {
namespace {

namespace fs = std::filesystem;
using scene::FeatureKind;
using scene::Shape;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// Two balls above a bin; the bin is the goal. The bin's middle is at (30, 10, 0) mm.
scene::Scene two_balls() {
  scene::Scene scene;
  for (std::uint32_t ball = 0; ball < 2; ++ball) {
    scene.features.push_back({.name = "ball " + std::to_string(ball + 1), .twin_of = 0});
    scene.parts.push_back(
        {.feature = ball, .shape = Shape::sphere, .size_m = {0.016, 0.016, 0.016}});
  }
  scene.features.push_back({.name = "bin", .kind = FeatureKind::wanted, .twin_of = 2});
  scene.parts.push_back({.feature = 2,
                         .shape = Shape::box,
                         .size_m = {0.02, 0.02, 0},
                         .position_m = {0.03, 0.01, 0}});
  return scene;
}

/// Ball 1 flies for half a second, then rests. Ball 2 enters at 0.2 s and rests.
ShownAnimation falling(double y_mps = 0.05) {
  const std::vector<motion::Segment> segments{
      {.body = 0,
       .position_m = {0, 0, 0.1},
       .velocity_mps = {0.1, y_mps, 0},
       .acceleration_mps2 = {0, 0, -0.6}},
      {.body = 0,
       .start_s = 0.5,
       .mode = motion::Mode::resting,
       .position_m = {0.05, 0.5 * y_mps, 0.025}},
      {.body = 1, .start_s = 0.2, .mode = motion::Mode::resting, .position_m = {-0.02, 0, 0.008}}};
  return {.title = "chain 1, scan 3", .motion = motion::Animation::of(segments, 2).value()};
}

/// Returns a frame's balls in the order in which they are drawn.
std::vector<plot::Disc> balls_of(const plot::Figure& frame) {
  std::vector<plot::Disc> balls;
  for (const plot::Disc& disc : all_of<plot::Disc>(frame.panels.front())) {
    if (disc.filled) balls.push_back(disc);
  }
  return balls;
}

std::vector<std::string> texts_of(const plot::Figure& frame) {
  std::vector<std::string> texts;
  for (const plot::Text& text : all_of<plot::Text>(frame.panels.front()))
    texts.push_back(text.text);
  return texts;
}

/// Returns the bin's middle in the view from above.
plot::Point bin_in(const plot::Figure& frame) {
  plot::Point sum;
  const plot::Polygon bin = all_of<plot::Polygon>(frame.panels.front()).at(0);
  for (const plot::Point& corner : bin.corners)
    sum = {sum.x + corner.x / 4, sum.y + corner.y / 4};
  return sum;
}

std::string text_of(const fs::path& place) {
  std::ifstream file(place, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

/// Replaces the environment variable PATH, or prepends a folder to it, during the object's
/// lifetime.
class OtherPath {
 public:
  explicit OtherPath(const std::string& programs) : before_(std::getenv("PATH")) {
    ::setenv("PATH", programs.c_str(), 1);
  }
  OtherPath(const OtherPath&) = delete;
  OtherPath& operator=(const OtherPath&) = delete;
  ~OtherPath() { ::setenv("PATH", before_.c_str(), 1); }

 private:
  std::string before_;
};

class Frames : public archive::testing::Scratch {
 protected:
  /// Returns a PATH that begins with a new folder. The folder contains the script, named ffmpeg.
  std::string path_with_ffmpeg(const std::string& script) const {
    const fs::path folder = path("bin");
    fs::create_directories(folder);
    const fs::path program = folder / "ffmpeg";
    std::ofstream(program) << "#!/bin/sh\n" << script;
    ::chmod(program.c_str(), 0755);
    return folder.string() + ":" + std::getenv("PATH");
  }

  const scene::Scene scene = two_balls();
  const ShownAnimation animation = falling();
};

TEST_F(Frames, ShowBodiesWhereTheirMotionHasThem) {
  // Goal: each ball is drawn at its place at any time, and not drawn before it enters. All frames
  // have the same size and scale. Method: measure how far each ball is from the bin's middle, in
  // units of the ball's radius.
  const plot::Figure first = frame_figure(scene, animation, 0);
  const plot::Point bin = bin_in(first);
  for (const double t_s : {0.0, 0.1, 0.2, 0.37, 0.5, 2.0}) {
    const plot::Figure frame = frame_figure(scene, animation, t_s);
    EXPECT_EQ(frame.width_px, first.width_px);
    EXPECT_EQ(frame.height_px, first.height_px);
    EXPECT_EQ(std::fmod(frame.width_px, 2), 0);
    EXPECT_EQ(std::fmod(frame.height_px, 2), 0);
    EXPECT_EQ(bin_in(frame).x, bin.x);
    std::vector<math::Vec3> expected_m;
    for (const motion::Path& way : animation.motion.paths()) {
      if (const auto centre_m = way.centre_at(t_s)) expected_m.push_back(*centre_m);
    }
    const std::vector<plot::Disc> balls = balls_of(frame);
    ASSERT_EQ(balls.size(), 2 * expected_m.size()) << t_s;
    const double px_per_m = balls.front().radius_x / 0.008;
    EXPECT_DOUBLE_EQ(px_per_m, balls_of(first).front().radius_x / 0.008);
    for (const math::Vec3& centre_m : expected_m) {
      const auto is_at = [&](const plot::Disc& disc) {
        return std::abs(disc.center.x - bin.x - px_per_m * (centre_m.x() - 0.03)) < 1e-6 &&
               std::abs(disc.center.y - bin.y - px_per_m * (centre_m.y() - 0.01)) < 1e-6;
      };
      EXPECT_EQ(std::ranges::count_if(balls, is_at), 1) << t_s;
    }
    if (expected_m.size() == 2) {
      std::vector<double> heights_px;
      for (const plot::Disc& ball : std::span(balls).last(2))
        heights_px.push_back(ball.center.y);
      EXPECT_NEAR(std::abs(heights_px[0] - heights_px[1]),
                  px_per_m * std::abs(expected_m[0].z() - expected_m[1].z()), 1e-6);
    }
  }
}

TEST_F(Frames, SayWhichAnimationAndWhen) {
  const plot::Figure frame = frame_figure(scene, animation, 0.25);
  EXPECT_EQ(frame.panels.front().title, "chain 1, scan 3");
  EXPECT_THAT(texts_of(frame), ::testing::IsSupersetOf({"from above", "from the front", "0.25 s"}));
  const auto views = [&](FrameViews which, const ShownAnimation& of) {
    std::vector<std::string> found;
    for (const std::string& text : texts_of(frame_figure(scene, of, 0, {.views = which}))) {
      if (text.starts_with("from")) found.push_back(text);
    }
    return found;
  };
  EXPECT_THAT(views(FrameViews::above, animation), ElementsAre("from above"));
  EXPECT_THAT(views(FrameViews::front, animation), ElementsAre("from the front"));
  EXPECT_THAT(views(FrameViews::both, falling(0)), ElementsAre("from the front"));
}

TEST_F(Frames, FitTheirSizes) {
  // Goal: frames are no larger than requested, and nothing in them is cut off.
  for (const double width_px : {100.0, 480.0, 1920.0}) {
    for (const double height_px : {100.0, 360.0, 1080.0}) {
      for (const FrameViews views : {FrameViews::both, FrameViews::above, FrameViews::front}) {
        const plot::Figure frame =
            frame_figure(scene, animation, 0.3,
                         {.views = views, .width_max_px = width_px, .height_max_px = height_px});
        EXPECT_LE(frame.width_px, width_px);
        EXPECT_LE(frame.height_px, height_px);
        const plot::Panel& panel = frame.panels.front();
        for (const plot::Disc& ball : balls_of(frame)) {
          EXPECT_GE(ball.center.x - ball.radius_x, 0);
          EXPECT_GE(ball.center.y - ball.radius_x, 0);
          EXPECT_LE(ball.center.x + ball.radius_x, panel.x_range->high);
          EXPECT_LE(ball.center.y + ball.radius_x, panel.y_range->high);
        }
        EXPECT_THAT(plot::to_svg(frame), Not(HasSubstr("nan")));
      }
    }
  }
}

TEST_F(Frames, AreCounted) {
  EXPECT_EQ(frame_count(animation.motion, 24), 13U);  // half a second
  EXPECT_EQ(frame_count(animation.motion, 23.9), 12U);
  EXPECT_EQ(frame_count(animation.motion, 1), 1U);
  EXPECT_EQ(frame_count(motion::Animation(), 24), 1U);
  for (const double fps : {0.0, -1.0, std::nan(""), 1e9}) {
    EXPECT_EQ(tests::failure_of([&] { (void)frame_count(animation.motion, fps); },
                                "more than 0|at most 1000"),
              base::ExitCode::usage);
  }
  const auto week = motion::Animation::of(
      std::vector<motion::Segment>{{.start_s = 7 * 86400.0, .mode = motion::Mode::resting}}, 1);
  EXPECT_EQ(tests::failure_of([&] { (void)frame_count(week.value(), 24); }, "604800 s|24|100000"),
            base::ExitCode::usage);
}

TEST_F(Frames, AreWrittenAsPngFiles) {
  // Goal: each file contains its frame, the new folder contains no other file, and progress is
  // reported. Method: compare each file byte by byte with a frame that is drawn separately.
  const std::string folder = path("frames");
  std::vector<std::pair<std::size_t, std::size_t>> told;
  const std::size_t count = write_png_frames(
      scene, animation, folder + "/",
      {.fps = 4, .name = "throw", .progress = [&](std::size_t done, std::size_t of) {
         told.emplace_back(done, of);
       }});
  EXPECT_EQ(count, 3U);
  EXPECT_THAT(told, ElementsAre(std::pair(1, 3), std::pair(2, 3), std::pair(3, 3)));
  EXPECT_THAT(names_in(folder), ElementsAre("throw-0001.png", "throw-0002.png", "throw-0003.png"));
  EXPECT_THAT(names_in(fs::path(folder).parent_path()), ElementsAre("frames"));
  for (std::size_t frame = 0; frame < count; ++frame) {
    const std::string name = "/throw-000" + std::to_string(frame + 1) + ".png";
    const base::Bytes whole =
        plot::Film(frame_figure(scene, animation, static_cast<double>(frame) / 4)).png();
    const std::string expected(reinterpret_cast<const char*>(whole.data()), whole.size());
    EXPECT_TRUE(text_of(folder + name) == expected) << name;
  }
}

TEST_F(Frames, NothingOfOthersIsOverwritten) {
  // Goal: if a folder has files, it stays unchanged. If writing fails, no file is left behind.
  // Method: write into a folder that has a file. Then write with a progress callback that throws.
  const fs::path folder = path("mine");
  fs::create_directory(folder);
  std::ofstream(folder / "frame-0001.png") << "dear";
  EXPECT_EQ(tests::failure_of([&] { write_png_frames(scene, animation, folder.string(), {}); },
                              "mine: |exists"),
            base::ExitCode::usage);
  EXPECT_EQ(text_of(folder / "frame-0001.png"), "dear");
  const auto stopped = [](std::size_t done, std::size_t) {
    if (done == 2) throw std::runtime_error("enough");
  };
  EXPECT_THROW(write_png_frames(scene, animation, path("new"), {.progress = stopped}),
               std::runtime_error);
  EXPECT_THAT(names_in(folder.parent_path()), ElementsAre("mine"));
  fs::remove(folder / "frame-0001.png");
  EXPECT_EQ(write_png_frames(scene, animation, folder.string(), {.fps = 2}), 2U);
  EXPECT_EQ(names_in(folder).size(), 2U);
}

TEST_F(Frames, GoToFfmpegAsPixels) {
  // Goal: ffmpeg gets the right arguments and all bytes of the frames. The film gets its final name
  // once it is complete. Method: run a script that records its arguments and counts bytes.
  const std::string output = path("a film.mp4");
  {
    const OtherPath path(
        path_with_ffmpeg("for last; do echo \"$last\"; done > \"$0.arguments\"\n"
                         "wc -c > \"$0.bytes\"\n"
                         "printf '\\0\\0\\0\\010moov\\0\\0\\0\\010mdat' > "
                         "\"${last#file:}\"\n"));
    EXPECT_EQ(write_mp4(scene, animation, output, {.fps = 12.5}), 7U);
  }
  const plot::Figure frame = frame_figure(scene, animation, 0);
  EXPECT_EQ(std::stod(text_of(path("bin") + "/ffmpeg.bytes")),
            7 * 4 * frame.width_px * frame.height_px);
  std::istringstream lines(text_of(path("bin") + "/ffmpeg.arguments"));
  std::vector<std::string> arguments;
  for (std::string line; std::getline(lines, line);)
    arguments.push_back(line);
  std::vector<std::string> expected =
      ffmpeg_command({.output = arguments.back().substr(5),
                      .columns = static_cast<std::uint32_t>(frame.width_px),
                      .rows = static_cast<std::uint32_t>(frame.height_px),
                      .fps = 12.5});
  expected.erase(expected.begin());
  EXPECT_EQ(arguments, expected);
  EXPECT_THAT(arguments, ::testing::IsSupersetOf({"libx264", "yuv420p", "rawvideo", "12.5"}));
  EXPECT_THAT(arguments.back(), ::testing::MatchesRegex("file:.*/a film[.]mp4[.]tmp[.][0-9]+"));
  EXPECT_THAT(names_in(fs::path(output).parent_path()), ElementsAre("a film.mp4", "bin"));
}

TEST_F(Frames, FfmpegsFailureIsShown) {
  // Goal: if ffmpeg fails, its messages are shown without control characters, and no file is left.
  // Method: run scripts that fail in different ways: at once, at the end, by a signal, or without a
  // message. Run scripts that leave an incomplete file. Write a film without ffmpeg.
  const std::string output = path("film.mp4");
  const auto refused = [&](const std::string& programs, const std::string& words) {
    const OtherPath other(programs);
    EXPECT_EQ(tests::failure_of([&] { write_mp4(scene, animation, output, {}); }, words),
              base::ExitCode::environment);
    EXPECT_FALSE(fs::exists(output));
  };
  refused(path_with_ffmpeg("seq 1 20 >&2; printf 'no \\033[2Jcodec\\n' >&2; exit 1\n"),
          "ffmpeg|:\n  16\n  17\n  18\n  19\n  20\n  no \xEF\xBF\xBD[2Jcodec");
  refused(path_with_ffmpeg("cat > /dev/null; echo 'disk full' >&2; exit 3\n"),
          "video:\n  disk full");
  refused(path_with_ffmpeg("cat > /dev/null; kill -9 $$\n"), "printed no reason");
  // The script succeeds but leaves a file that ends inside a box or before the index, as on a full
  // disk.
  for (const char* film : {"\\0\\0\\0\\010moov\\0\\0\\0\\020mdat", "\\0\\0\\0\\010mdat"}) {
    refused(path_with_ffmpeg(fmt::format("cat > /dev/null; for last; do :; done\n"
                                         "printf '{}' > \"${{last#file:}}\"\n",
                                         film)),
            "is the disk full?");
  }
  fs::create_directory(path("none"));
  refused(path("none"), "ffmpeg|not installed");
  EXPECT_THAT(names_in(fs::path(output).parent_path()), ElementsAre("bin", "none"));
}

TEST_F(Frames, TheRealFfmpegMakesAFilm) {
  // Goal: the real ffmpeg accepts the command, and a second run produces the same file. Method:
  // check that the MP4 begins with the box `ftyp` and contains the number of frames.
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "there is no ffmpeg on PATH: apt-get install ffmpeg";
  const std::string output = path("film.mp4");
  ASSERT_EQ(write_mp4(scene, animation, output, {}), 13U);
  const std::string film = text_of(output);
  EXPECT_EQ(film.substr(4, 4), "ftyp");
  // The box stsz contains a version, the sample size (0: the size varies) and the number of
  // samples.
  const std::size_t sizes = film.find("stsz");
  ASSERT_NE(sizes, std::string::npos);
  EXPECT_EQ(film.substr(sizes + 12, 4), std::string("\0\0\0\x0d", 4));
  ASSERT_EQ(write_mp4(scene, animation, output, {}), 13U);
  EXPECT_TRUE(text_of(output) == film);
}

TEST_F(Frames, TheWholeMotionIsAnSvg) {
  const std::string output = path("throw.svg");
  write_motion_svg("balls", scene, animation, output);
  EXPECT_EQ(text_of(output), plot::to_svg(animation_figure("balls", scene, {animation})));
  EXPECT_EQ(tests::failure_of([&] { write_motion_svg("balls", scene, animation, "throw.png"); },
                              "throw.png: |.svg"),
            base::ExitCode::usage);
}

}  // namespace
}  // namespace sleight::pictures
