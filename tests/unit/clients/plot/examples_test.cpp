#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "clients/plot/png.h"
#include "clients/plot/save.h"
#include "clients/plot/svg.h"
#include "common/base/error.h"
#include "tests/unit/clients/plot/examples.h"

namespace sleight::plot {
namespace {

std::string picture_path(const std::string& name) {
  const char* folder = std::getenv("SLEIGHT_PICTURES");
  return (folder != nullptr ? std::string(folder) + "/" : testing::TempDir()) + name;
}

TEST(Examples, AreDrawnToFiles) {
  // Goal: each example figure is saved as SVG and as PNG, and no partial file is left.
  const std::pair<const char*, Figure> k_figures[] = {
      {"landing", landing_figure()}, {"paths", paths_figure()}, {"hostile", hostile_figure()}};
  for (const auto& [name, figure] : k_figures) {
    for (const char* ending : {".svg", ".png"}) {
      const std::string path = picture_path(std::string(name) + ending);
      save(figure, path);
      EXPECT_GT(std::filesystem::file_size(path), 1000U) << path;
      EXPECT_FALSE(std::filesystem::exists(path + ".part")) << path;
    }
  }
}

TEST(Png, RefusesWhatIsNoPicture) {
  // Goal: the PNG converter refuses invalid SVG and absurdly large scales with an error, and
  // doesn't crash.
  EXPECT_THROW(svg_to_png("", 1), base::Error);
  EXPECT_THROW(svg_to_png("<svg", 1), base::Error);
  EXPECT_THROW(svg_to_png("<html/>", 1), base::Error);
  EXPECT_THROW(to_png(landing_figure(), 1e6), base::Error);
}

TEST(Save, ExplainsWhatIsWrong) {
  // Goal: a save is refused if the file's ending is unknown, if a PNG file should have notes, or if
  // the folder is missing. Each refusal has the right exit code.
  const Figure figure{.panels = {Panel{}}};
  try {
    save(figure, "trace.jpeg");
    FAIL() << "an unknown ending was taken";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::usage);
    EXPECT_NE(std::string(error.what()).find("trace.jpeg"), std::string::npos);
  }
  try {
    save(figure, testing::TempDir() + "trace.png", {.notes = {{.name = "seed", .value = "1"}}});
    FAIL() << "notes were lost in a PNG";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::usage);
  }
  const std::string nowhere = testing::TempDir() + "no/such/folder/trace.svg";
  try {
    save(figure, nowhere);
    FAIL() << "a folder that does not exist was written to";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::environment);
    EXPECT_NE(std::string(error.what()).find(nowhere + ": "), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("No such file"), std::string::npos) << error.what();
  }
}

TEST(Save, TellsOfAFullDisk) {
  // Goal: a full disk is an error. Method: save a figure through a link to /dev/full, if that
  // device exists.
  const std::string path = testing::TempDir() + "full.svg";
  std::error_code failure;
  std::filesystem::remove(path, failure);
  std::filesystem::create_symlink("/dev/full", path, failure);
  if (failure || !std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(save(landing_figure(), path), base::Error);
  EXPECT_TRUE(std::filesystem::is_symlink(path));
}

}  // namespace
}  // namespace sleight::plot
