#include "clients/world_plots/ball_2d.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "clients/analysis/archive_rows.h"
#include "clients/analysis/request_numbers.h"
#include "clients/browse/archives/kept_animations.h"
#include "clients/pictures/trace.h"
#include "common/archive/format.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::world_plots {
namespace {

using analysis::RequestNumbers;
using analysis::Rows;

constexpr const char* k_paths = "paths";

constexpr int k_points_per_hop = 40;

/// Most hops of a path.
constexpr std::uint64_t k_hops_max = 10'000;

/// Panels beside each other.
constexpr std::size_t k_columns_max = 4;

struct Asked {
  double diameter_m;
  double target;  ///< in diameters, as all that follows
  double tolerance;
  double gravity_mps2;
  std::string step;  ///< what a draw is called
};

Asked asked_of(const archive::Source& source) {
  const RequestNumbers numbers(archive::summary_of(source).request_text, source.name());
  const Asked asked{.diameter_m = numbers.at("world", "diameter_m"),
                    .target = numbers.at("constraint", "target_diameters"),
                    .tolerance = numbers.at("constraint", "tolerance_diameters"),
                    .gravity_mps2 = numbers.at("world", "gravity_mps2"),
                    .step = analysis::scan_label(numbers)};
  if (!(asked.diameter_m > 0 && asked.tolerance >= 0) || !std::isfinite(asked.diameter_m) ||
      !std::isfinite(asked.target) || !std::isfinite(asked.tolerance) ||
      !std::isfinite(asked.gravity_mps2)) {
    throw base::Error(base::ExitCode::bad_archive,
                      source.name() + ": its request has numbers that no ball has");
  }
  return asked;
}

/// The hops of one animation, in columns.
struct Segments {
  std::vector<double> duration_s;
  std::vector<double> position_m;    ///< x, z pairs
  std::vector<double> velocity_mps;  ///< x, z pairs
  std::vector<double> normal_rad;    ///< of the collision that began it; NaN for the drop
};

/// x and z of vectors.
std::vector<double> in_plane(const std::vector<double>& vectors) {
  std::vector<double> pairs;
  for (std::size_t i = 0; i + 2 < vectors.size(); i += 3)
    pairs.insert(pairs.end(), {vectors[i], vectors[i + 2]});
  return pairs;
}

Segments read_segments(const archive::Source& source, std::size_t animation) {
  const analysis::Rows rows = browse::segments_of(source, animation, k_hops_max);
  if (rows.count == 0) browse::refuse_animation(source, animation, "has no motion");
  const std::vector<double> start_s =
      analysis::read_rows(source, archive::k_animations, "start_s", 1, rows);
  const std::uint64_t hops = rows.count - 1;  // the last row is where the ball lies
  Segments segments{
      .duration_s = {},
      .position_m =
          in_plane(analysis::read_rows(source, archive::k_animations, "position_m", 3, rows)),
      .velocity_mps =
          in_plane(analysis::read_rows(source, archive::k_animations, "velocity_mps", 3, rows)),
      .normal_rad = {std::numeric_limits<double>::quiet_NaN()}};
  for (std::size_t i = 0; i < hops; ++i)
    segments.duration_s.push_back(start_s[i + 1] - start_s[i]);
  if (hops == 0) return segments;
  const std::vector<double> normals = analysis::read_rows(
      source, archive::k_animations, "normal_rad", hops - 1, {.first = animation, .count = 1});
  segments.normal_rad.insert(segments.normal_rad.end(), normals.begin(), normals.end());
  return segments;
}

/// One hop as points of its parabola, in diameters.
void append_hop(const Segments& segments, std::size_t row, const Asked& asked,
                std::vector<plot::Point>& path) {
  for (int i = 0; i <= k_points_per_hop; ++i) {
    const double t = segments.duration_s[row] * i / k_points_per_hop;
    const double x_m = segments.position_m[2 * row] + segments.velocity_mps[2 * row] * t;
    const double z_m = segments.position_m[2 * row + 1] + segments.velocity_mps[2 * row + 1] * t -
                       0.5 * asked.gravity_mps2 * t * t;
    path.push_back({x_m / asked.diameter_m, z_m / asked.diameter_m});
  }
}

/// The range of nearly all values, so that the few of a chain's way from its start don't flatten
/// the rest; it includes `least`. Values outside are cut, as in the thesis's figure.
plot::Range range_of_most(std::vector<double> values, const plot::Range& least) {
  plot::Range range = least;
  if (!values.empty()) {
    std::sort(values.begin(), values.end());
    const std::size_t tail = values.size() / 20;
    range.low = std::min(range.low, values[tail]);
    range.high = std::max(range.high, values[values.size() - 1 - tail]);
  }
  const double margin = 0.3 * (range.high - range.low);
  return {.low = range.low - margin, .high = range.high + margin};
}

void append_values(const std::vector<plot::Point>& points, std::vector<double>& values) {
  for (const plot::Point& point : points) {
    if (std::isfinite(point.y)) values.push_back(point.y);
  }
}

plot::Panel path_panel(const Segments& segments, const Asked& asked) {
  plot::Panel panel{
      .x_label = "x (ball diameters)", .y_label = "height (diameters)", .equal_aspect = true};
  // The target is a flat disc on the table, the table the line on which the ball's centre bounces.
  panel.series.push_back(
      plot::HorizontalLine{.y = 0, .color = plot::palette::k_grey, .dashed = false});
  panel.series.push_back(plot::Disc{.center = {asked.target, 0},
                                    .radius_x = std::max(asked.tolerance, 0.02),
                                    .radius_y = 0.06,
                                    .label = "target"});
  std::vector<plot::Point> path;
  std::vector<plot::Series> arrows;
  for (std::size_t row = 0; row < segments.duration_s.size(); ++row) {
    append_hop(segments, row, asked, path);
    const double tilt = segments.normal_rad[row];
    if (std::isnan(tilt)) continue;
    const plot::Point foot{segments.position_m[2 * row] / asked.diameter_m, 0};
    const double length = 0.6;
    arrows.push_back(
        plot::Arrow{.from = foot,
                    .to = {foot.x + length * std::sin(tilt), foot.y + length * std::cos(tilt)},
                    .label = "normal"});
  }
  panel.series.push_back(plot::Line{.points = std::move(path), .label = "ball's centre"});
  panel.series.insert(panel.series.end(), arrows.begin(), arrows.end());
  return panel;
}

plot::Figure trace_figure(const archive::Source& source, const pictures::DrawnPart& part) {
  const Asked asked = asked_of(source);
  plot::Panel landing{.title = "Where the ball lands",
                      .x_label = asked.step,
                      .y_label = "x (ball diameters)",
                      .height_share = 1.6};
  landing.series.push_back(plot::HorizontalBand{.low = asked.target - asked.tolerance,
                                                .high = asked.target + asked.tolerance,
                                                .label = "satisfied"});
  plot::Panel log_p{.title = "log p", .x_label = asked.step, .y_label = "log p"};

  const std::vector<std::uint64_t> chains = pictures::chains_to_draw(source, part.chain);
  std::vector<double> all_landings;
  std::vector<double> all_log_p;
  for (std::size_t i = 0; i < chains.size(); ++i) {
    const pictures::TraceRange range{.chain = chains[i], .draws = part.draws};
    const std::string label = fmt::format("chain {}", chains[i]);
    std::vector<plot::Point> x =
        pictures::trace(source, "landing_x_m", range, 1 / asked.diameter_m);
    std::vector<plot::Point> lp = pictures::trace(source, "lp", range, 1);
    append_values(x, all_landings);
    append_values(lp, all_log_p);
    landing.series.push_back(plot::Steps{
        .points = std::move(x), .color = plot::palette::series(i), .label = label, .width_px = 1});
    log_p.series.push_back(
        plot::Steps{.points = std::move(lp), .color = plot::palette::series(i), .width_px = 1});
  }
  landing.y_range = range_of_most(
      std::move(all_landings),
      {.low = asked.target - asked.tolerance, .high = asked.target + asked.tolerance});
  const double best = all_log_p.empty() ? 0 : *std::max_element(all_log_p.begin(), all_log_p.end());
  log_p.y_range = range_of_most(std::move(all_log_p), {.low = best - 1, .high = best});
  return {.title = "2D ball",
          .width_px = 900,
          .height_px = 560,
          .panels = {std::move(landing), std::move(log_p)}};
}

plot::Figure paths_figure(const archive::Source& source, const pictures::DrawnPart& part) {
  const Asked asked = asked_of(source);
  const std::vector<std::size_t> chosen = browse::choose_animations(source, part.chain, part.count);
  const std::vector<double> chains = browse::of_animations(source, "chain");
  const std::vector<double> scans = browse::of_animations(source, "draw");
  const std::size_t columns = std::min(chosen.size(), k_columns_max);
  const std::size_t rows = (chosen.size() - 1) / columns + 1;
  plot::Figure figure{.title = "2D ball: paths that land at the target",
                      .width_px = 360.0 * static_cast<double>(columns),
                      .height_px = 520.0 * static_cast<double>(rows),
                      .columns = columns,
                      .panels = {}};
  for (const std::size_t i : chosen) {
    plot::Panel panel = path_panel(read_segments(source, i), asked);
    panel.title = fmt::format("chain {}, draw {}", chains[i], scans[i]);
    panel.legend = i == chosen.front();
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace

std::string Ball2d::world() const {
  return "ball_2d";
}

std::vector<pictures::WorldPlots::Kind> Ball2d::kinds() const {
  return {{.what = std::string(pictures::k_trace)},
          {.what = k_paths, .help = "the same as the thesis shows it"}};
}

pictures::Picture Ball2d::draw(std::string_view what, const archive::Source& source,
                               const pictures::DrawnPart& part) const {
  return {.figure = what == k_paths ? paths_figure(source, part) : trace_figure(source, part)};
}

}  // namespace sleight::world_plots
