#include "clients/plot/layout.h"

#include <gtest/gtest.h>

#include "clients/plot/text.h"
#include "tests/unit/clients/plot/examples.h"

namespace sleight::plot {
namespace {

TEST(Layout, KeepsFramesApartAndInside) {
  // Goal: each frame and its labels stay inside their cell, and each cell stays on the page. On
  // tiny pages, each frame has at least 8 x 8 pixels. Method: lay out the example figures at
  // several sizes.
  for (Figure figure : {landing_figure(), paths_figure(), hostile_figure()}) {
    for (const double scale : {0.05, 0.5, 1.0, 3.0}) {
      Figure sized = figure;
      sized.width_px *= scale;
      sized.height_px *= scale;
      const FigureLayout layout = layout_of(sized);
      ASSERT_EQ(layout.panels.size(), figure.panels.size());
      for (const PanelLayout& panel : layout.panels) {
        ASSERT_GE(panel.frame.width, 8) << scale;
        ASSERT_GE(panel.frame.height, 8) << scale;
        if (scale < 0.5) continue;
        ASSERT_LE(panel.cell.right(), sized.width_px + 1e-9);
        ASSERT_LE(panel.cell.bottom(), sized.height_px + 1e-9);
        ASSERT_GE(panel.frame.left, panel.cell.left);
        ASSERT_LE(panel.frame.right(), panel.cell.right() + 1e-9);
        ASSERT_LT(panel.frame.bottom(), panel.cell.bottom());
        for (const std::string& label : panel.y_ticks.labels) {
          ASSERT_GE(panel.frame.left - 8 - text_width_px(label, style::k_tick_label),
                    panel.cell.left - 1e-9)
              << label;
        }
      }
    }
  }
}

TEST(Layout, SeparatesTickLabels) {
  // Goal: neighbouring labels on the x axis never overlap. Method: compare each label's left end
  // with the right end of the label before it.
  Figure wide{.width_px = 360,
              .panels = {Panel{.x_range = Range{100000, 100001}}, Panel{.x_range = Range{0, 9e9}}}};
  for (const Figure& figure : {landing_figure(), paths_figure(), hostile_figure(), wide}) {
    for (const PanelLayout& panel : layout_of(figure).panels) {
      double free_from = -1e9;
      for (std::size_t i = 0; i < panel.x_ticks.values.size(); ++i) {
        const double middle = panel.to_pixels({panel.x_ticks.values[i], 0}).x;
        const double half = text_width_px(panel.x_ticks.labels[i], style::k_tick_label) / 2;
        EXPECT_GT(middle - half, free_from) << panel.x_ticks.labels[i];
        free_from = middle + half;
      }
    }
  }
}

TEST(Layout, NarrowPanelsStillHaveAScale) {
  // Goal: the x axis of a narrow panel has at least two ticks, and the labels of the ticks don't
  // overlap. Method: use ranges in which a coarse step gives only one tick.
  for (const double width_px : {250.0, 360.0}) {
    for (const Range range : {Range{-4, 4}, Range{-3.75, 3.75}, Range{-0.9, 0.9}, Range{1, 9}}) {
      const Figure figure{.width_px = width_px, .panels = {Panel{.x_range = range}}};
      const PanelLayout panel = layout_of(figure).panels.front();
      ASSERT_GE(panel.x_ticks.values.size(), 2U) << range.low << ", " << width_px;
      for (std::size_t i = 0; i + 1 < panel.x_ticks.values.size(); ++i) {
        const double between = panel.to_pixels({panel.x_ticks.values[i + 1], 0}).x -
                               panel.to_pixels({panel.x_ticks.values[i], 0}).x;
        EXPECT_GT(between, 0.5 * (text_width_px(panel.x_ticks.labels[i], style::k_tick_label) +
                                  text_width_px(panel.x_ticks.labels[i + 1], style::k_tick_label)));
      }
    }
  }
}

TEST(Layout, LinesUpPanelsOfAColumn) {
  // Goal: the x axes of stacked panels begin and end at the same place. Method: use two panels
  // whose y labels differ greatly in width.
  const Figure figure{
      .panels = {Panel{.y_range = Range{0, 1}}, Panel{.y_range = Range{0, 123456}}}};
  const FigureLayout layout = layout_of(figure);
  EXPECT_DOUBLE_EQ(layout.panels[0].frame.left, layout.panels[1].frame.left);
  EXPECT_DOUBLE_EQ(layout.panels[0].frame.right(), layout.panels[1].frame.right());
}

TEST(Layout, DrawingsWithoutAxesFillTheirCell) {
  // Goal: if a panel has no axes, it fills its cell below the title and has no ticks.
  const Panel panel{.title = "a drawing", .x_label = "x", .y_label = "y", .axes = false};
  const PanelLayout layout = layout_of({.panels = {panel}}).panels[0];
  EXPECT_DOUBLE_EQ(layout.frame.left, layout.cell.left);
  EXPECT_DOUBLE_EQ(layout.frame.right(), layout.cell.right());
  EXPECT_DOUBLE_EQ(layout.frame.bottom(), layout.cell.bottom());
  EXPECT_DOUBLE_EQ(layout.frame.top, layout.cell.top + style::k_panel_title + 9);
  EXPECT_TRUE(layout.x_ticks.values.empty());
  EXPECT_TRUE(layout.y_ticks.values.empty());
}

TEST(Layout, LegendNamesEachLabelOnceAndWraps) {
  // Goal: arrows with the same label share one legend entry. Many entries fill several rows, and no
  // row is wider than the frame.
  Panel panel;
  for (int i = 0; i < 3; ++i)
    panel.series.push_back(Arrow{.label = "normal"});
  EXPECT_EQ(legend_entries(panel).size(), 1U);
  for (int i = 0; i < 12; ++i) {
    panel.series.push_back(Line{.label = "chain number " + std::to_string(i)});
  }
  const PanelLayout layout = layout_of({.width_px = 400, .panels = {panel}}).panels[0];
  ASSERT_EQ(layout.legend.size(), 13U);
  for (const LegendEntry& entry : layout.legend) {
    const double right =
        entry.left + style::k_legend_swatch + 6 + text_width_px(entry.label, style::k_legend);
    EXPECT_LE(right, layout.frame.right() + 1e-9) << entry.label;
    EXPECT_LT(entry.baseline, layout.frame.top);
  }
  panel.legend = false;
  EXPECT_TRUE(layout_of({.panels = {panel}}).panels[0].legend.empty());
}

}  // namespace
}  // namespace sleight::plot
