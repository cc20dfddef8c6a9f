#include "clients/world_plots/spelling.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/error.h"
#include "tests/archive/small_archive.h"
#include "tests/support/refusals.h"
#include "tests/unit/clients/pictures/panel_series.h"

namespace sleight::world_plots {
namespace {

using pictures::all_of;
using ::testing::ElementsAre;
using tests::failure_of;

class SmallArchive final : public archive::StoredArchive {
 public:
  explicit SmallArchive(bool has_balls = true)
      : StoredArchive("spelling", "[sampler]\niterations_per_scan = 10\n", 0) {
    add_statistic("filled", {0, 1, 1, 2, 0, 0, 0, 1});
    add_animations(0);
    if (has_balls)
      add_anywhere("/posterior", "active", {{"chain", 2}, {"draw", 4}, {"ball", 2}}, {});
  }
};

TEST(SpellingTrace, CountsIterations) {
  // Goal: the trace shows the number of filled bins. The x axis counts iterations, not scans. A
  // line marks the total number of bins. Method: draw the trace of a small archive, for one chain
  // and for all chains.
  const Spelling spelling;
  const SmallArchive source;
  const plot::Figure one =
      spelling.draw(pictures::k_trace, source, {.chain = 0, .draws = 3}).figure;
  ASSERT_EQ(one.panels.size(), 2U);
  const auto steps = all_of<plot::Steps>(one.panels[0]);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_THAT(steps[0].points,
              ElementsAre(plot::Point{0, 0}, plot::Point{10, 1}, plot::Point{20, 1}));
  const auto lines = all_of<plot::HorizontalLine>(one.panels[0]);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].y, 2);
  EXPECT_EQ(lines[0].label, "all 2");
  const plot::Figure all = spelling.draw(pictures::k_trace, source, {}).figure;
  EXPECT_EQ(all_of<plot::Steps>(all.panels[1]).size(), 2U);
  EXPECT_EQ(
      failure_of([&] { spelling.draw(pictures::k_trace, source, {.chain = 2}); }, "no chain 2"),
      base::ExitCode::usage);
  EXPECT_EQ(failure_of([&] { spelling.draw(pictures::k_trace, SmallArchive(false), {}); },
                       "/posterior/active: |chain|draw|ball"),
            base::ExitCode::bad_archive);
}

}  // namespace
}  // namespace sleight::world_plots
