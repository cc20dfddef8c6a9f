#include "tests/unit/clients/plot/examples.h"

#include <cmath>
#include <utility>

#include "tests/support/numbers.h"

namespace sleight::plot {

namespace {

// A path that starts at height 4.5, bounces on the table, and drifts towards the target at x = 1.
struct Path {
  std::vector<Point> points;
  std::vector<Arrow> normals;
};

Path bouncing_path(std::uint64_t seed) {
  constexpr double k_gravity = 9.81;
  MadeUp made_up(seed);
  Path path;
  double x = 0;
  double height = 4.5;
  double speed_x = 0;
  double fallen_from = height;
  for (int bounce = 0; bounce < 6; ++bounce) {
    const double fall_s = std::sqrt(2 * fallen_from / k_gravity);
    const double rise_s = bounce == 0 ? 0 : fall_s;
    for (int i = 0; i <= 60; ++i) {
      const double t = -rise_s + (rise_s + fall_s) * i / 60;
      path.points.push_back(
          {x + speed_x * (t + rise_s), 0.5 + fallen_from - 0.5 * k_gravity * t * t});
    }
    x = path.points.back().x;
    const double tilt = bounce == 0 ? 0.12 : 0.08 * made_up.normal();
    path.normals.push_back({.from = {x, 0},
                            .to = {x + 0.6 * std::sin(tilt), 0.6 * std::cos(tilt)},
                            .label = "normal"});
    speed_x = (1 - x) * (0.2 + 0.5 * made_up.uniform()) + 3 * tilt;
    fallen_from *= 0.5;
  }
  return path;
}

}  // namespace

Figure landing_figure() {
  MadeUp made_up(7);
  Line position{.label = "chain 0"};
  Steps log_p{.color = palette::k_vermillion, .label = "log p"};
  double x = 4.7;
  for (int i = 0; i < 1000; ++i) {
    if (made_up.uniform() < 0.6) x = 1 + (x - 1) * 0.55 + 0.06 * made_up.normal();
    position.points.push_back({static_cast<double>(i), x});
    const double off = (x - 1) / 0.1;
    log_p.points.push_back({static_cast<double>(i), -0.5 * off * off - 4 - made_up.uniform()});
  }
  Panel landing{.title = "Where the ball lands",
                .x_label = "iteration",
                .y_label = "landing position (D)",
                .x_range = Range{0, 1000},
                .y_range = Range{0.4, 1.8},
                .height_share = 1.6,
                .series = {HorizontalBand{.low = 0.9, .high = 1.1, .label = "target ± 0.1 D"},
                           HorizontalLine{.y = 1, .color = palette::k_green}, std::move(position)}};
  Panel plausible{.title = "How plausible it is",
                  .x_label = "iteration",
                  .y_label = "log p",
                  .x_range = Range{0, 1000},
                  .y_range = Range{-40, 0},
                  .series = {std::move(log_p)}};
  return {.title = "2D ball: 1,000 iterations of one chain",
          .height_px = 560,
          .panels = {std::move(landing), std::move(plausible)}};
}

Figure paths_figure() {
  Figure figure{.title = "Three sampled paths of the ball’s centre",
                .width_px = 960,
                .height_px = 560,
                .columns = 3};
  for (std::uint64_t i = 0; i < 3; ++i) {
    Path path = bouncing_path(11 + 7 * i);
    Panel panel{.title = "Sample " + std::to_string(100 * (i + 2)),
                .x_label = "x (D)",
                .y_label = i == 0 ? "height (D)" : "",
                .y_range = Range{-0.4, 5.4},
                .equal_aspect = true,
                .legend = i == 0};
    panel.series.push_back(HorizontalLine{.y = 0, .color = palette::k_grey, .dashed = false});
    panel.series.push_back(
        Disc{.center = {1, 0}, .radius_x = 0.5, .radius_y = 0.09, .label = "target"});
    panel.series.push_back(Line{.points = path.points, .label = "path", .width_px = 1.8});
    for (Arrow& normal : path.normals)
      panel.series.push_back(std::move(normal));
    panel.series.push_back(Disc{.center = path.points.back(),
                                .radius_x = 0.5,
                                .color = palette::k_grey,
                                .label = "ball at rest",
                                .filled = false});
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

Figure hostile_figure() {
  Panel gaps{
      .title = "gaps & <infinities> \"quoted\" \xFF\x01",
      .x_label =
          "a very long axis label that has no chance at all to fit below so small a "
          "panel and must be cut",
      .y_label = "y",
      .series = {Line{.points = {{0, 1}, {1, k_nan}, {2, 3}, {3, -k_infinity}, {4, 2}, {5, 2.5}},
                      .label = "line"},
                 Markers{.points = {{0.5, k_infinity}, {k_infinity, 2}, {k_nan, k_nan}, {2, 2}},
                         .color = palette::k_orange,
                         .label = "markers"},
                 Text{.at = {4, 2}, .text = "here & <now>", .anchor = Anchor::end}}};
  Panel constant{.title = "constant", .series = {Line{.points = {{1, 7e8}, {2, 7e8}, {3, 7e8}}}}};
  Panel one{.title = "one point", .series = {Steps{.points = {{1000, -1e-7}}}}};
  Panel empty{.title = "empty", .series = {Line{}, Steps{}, Markers{}}};
  Panel huge{.title = "huge", .series = {Line{.points = {{-1e140, -1e149}, {1e140, 1e149}}}}};
  Panel tiny{.title = "tiny", .series = {Line{.points = {{1e-9, 1e-12}, {2e-9, 3e-12}}}}};
  return {.title = "Hostile <input> & more of it",
          .columns = 3,
          .panels = {gaps, constant, one, empty, huge, tiny}};
}

}  // namespace sleight::plot
