// Goal: each world lists its own plots. These lists determine the names and the help of all plots,
// the trace that is drawn, and the error about a missing plot. Method: use plots of two made-up
// worlds, and archives of three worlds.
#include "clients/cli/plot_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "common/base/error.h"
#include "tests/archive/small_archive.h"
#include "tests/support/refusals.h"

namespace sleight::cli {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class MadeUpPlots final : public pictures::WorldPlots {
 public:
  MadeUpPlots(std::string world, std::vector<Kind> kinds)
      : world_(std::move(world)), kinds_(std::move(kinds)) {}

  std::string world() const override { return world_; }
  std::vector<Kind> kinds() const override { return kinds_; }
  pictures::Picture draw(std::string_view what, const archive::Source&,
                         const pictures::DrawnPart& part) const override {
    return {.figure = {.title = world_ + "'s " + std::string(what)},
            .words = std::to_string(part.count)};
  }

 private:
  std::string world_;
  std::vector<Kind> kinds_;
};

/// Returns two worlds. World "marbles" has the plots "trace" and "smoke"; world "rods" has the
/// plots "smoke" and "mirrors".
pictures::PlotsOfWorlds two_worlds() {
  pictures::PlotsOfWorlds worlds;
  worlds.push_back(std::make_unique<MadeUpPlots>(
      "marbles", std::vector<pictures::WorldPlots::Kind>{{"trace", ""}, {"smoke", "what burns"}}));
  worlds.push_back(std::make_unique<MadeUpPlots>(
      "rods", std::vector<pictures::WorldPlots::Kind>{{"smoke", "what glows"},
                                                      {"mirrors", "what shines"}}));
  return worlds;
}

PlotOptions asking_for(std::string what) {
  PlotOptions options;
  options.path = "small.h5";
  options.what = std::move(what);
  options.count = 7;
  return options;
}

TEST(PlotCommand, WhatCanBeAskedForComesFromTheWorlds) {
  const pictures::PlotsOfWorlds worlds = two_worlds();
  EXPECT_THAT(whats_of(worlds), ElementsAre("trace", "animations", "smoke", "mirrors"));
  EXPECT_THAT(whats_of({}), ElementsAre("trace", "animations"));
  EXPECT_THAT(help_of_whats(worlds), AllOf(HasSubstr("trace: "), HasSubstr("animations: "),
                                           HasSubstr("smoke: what burns (marbles, rods)"),
                                           HasSubstr("mirrors: what shines (rods)")));
}

TEST(PlotCommand, AWorldDrawsWhatItHas) {
  const pictures::PlotsOfWorlds worlds = two_worlds();
  const auto title = [&](const char* world, const char* what) {
    return picture_of(archive::BareArchive(world), asking_for(what), true, worlds).figure.title;
  };
  EXPECT_EQ(title("marbles", "trace"), "marbles's trace");
  EXPECT_EQ(title("marbles", "smoke"), "marbles's smoke");
  EXPECT_EQ(title("rods", "mirrors"), "rods's mirrors");
  EXPECT_EQ(title("rods", "trace"), "rods");
  EXPECT_EQ(title("gas", "trace"), "gas");
  EXPECT_EQ(picture_of(archive::BareArchive("rods"), asking_for("mirrors"), true, worlds).words,
            "7");
}

TEST(PlotCommand, WhatAnArchiveCannotHaveIsSaid) {
  const pictures::PlotsOfWorlds worlds = two_worlds();
  const auto refused = [&](const char* world, const char* what, const char* words) {
    EXPECT_EQ(tests::failure_of(
                  [&] { picture_of(archive::BareArchive(world), asking_for(what), true, worlds); },
                  words),
              base::ExitCode::usage);
  };
  refused("gas", "smoke", "--what smoke|marbles and rods|small.h5|gas");
  refused("marbles", "mirrors", "--what mirrors|rods|small.h5|marbles");
}

}  // namespace
}  // namespace sleight::cli
