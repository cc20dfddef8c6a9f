#include "clients/world_plots/ball_2d.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "clients/analysis/archive_rows.h"
#include "clients/analysis/request_numbers.h"
#include "clients/browse/archives/kept_animations.h"
#include "clients/pictures/trace.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/summary.h"
#include "common/base/error.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::world_plots {
namespace {

using analysis::RequestNumbers;

constexpr const char* k_paths = "paths";

constexpr int k_points_per_hop = 40;

/// Maximum hops per path.
constexpr std::uint64_t k_hops_max = 10'000;

/// Maximum panels beside each other.
constexpr std::size_t k_columns_max = 4;

struct Asked {
  double diameter_m;
  double target;  ///< all lengths are in diameters
  double tolerance;
  std::string step;  ///< name of a draw's unit
};

Asked asked_of(const archive::Source& source) {
  const RequestNumbers numbers(archive::summary_of(source).request_text, source.name());
  const Asked asked{.diameter_m = numbers.at("world", "diameter_m"),
                    .target = numbers.at("constraint", "target_diameters"),
                    .tolerance = numbers.at("constraint", "tolerance_diameters"),
                    .step = analysis::scan_label(numbers)};
  if (!(asked.diameter_m > 0 && asked.tolerance >= 0) || !std::isfinite(asked.diameter_m) ||
      !std::isfinite(asked.target) || !std::isfinite(asked.tolerance)) {
    throw base::Error(
        base::ExitCode::bad_archive,
        source.name() +
            ": the request has an invalid diameter_m, target_diameters or tolerance_diameters");
  }
  return asked;
}

/// An animation's hops: all segments except the last, in which the ball lies.
struct Hops {
  std::vector<motion::Segment> segments;
  std::vector<double> normal_rad;  ///< of the collision before each; NaN for the drop
};

Hops read_hops(const archive::Source& source, const scene::Scene& scene, std::size_t animation) {
  const auto motion =
      archive::KeptMotions(source, archive::k_animations).animation(animation, scene);
  if (!motion) browse::refuse_animation(source, animation, "is invalid: " + motion.error());
  if (motion.value().segment_count() == 0)
    browse::refuse_animation(source, animation, "has no motion");
  if (motion.value().segment_count() > k_hops_max)
    browse::refuse_animation(source, animation, fmt::format("has more than {} hops", k_hops_max));
  const auto segments = motion.value().path(0).segments();
  Hops hops{.segments = {segments.begin(), segments.end()},
            .normal_rad = {std::numeric_limits<double>::quiet_NaN()}};
  if (segments.size() < 2) return hops;
  const std::vector<double> normals =
      analysis::read_rows(source, archive::k_animations, "normal_rad", segments.size() - 2,
                          {.first = animation, .count = 1});
  hops.normal_rad.insert(hops.normal_rad.end(), normals.begin(), normals.end());
  return hops;
}

/// Appends points of a segment's parabola up to the next segment, in diameters.
void append_hop(const motion::Segment& segment, double end_s, double diameter_m,
                std::vector<plot::Point>& path) {
  for (int i = 0; i <= k_points_per_hop; ++i) {
    const double share = static_cast<double>(i) / k_points_per_hop;
    const math::Vec3 place_m =
        motion::position_at(segment, segment.start_s + share * (end_s - segment.start_s));
    path.push_back({place_m.x() / diameter_m, place_m.z() / diameter_m});
  }
}

/// Returns a range with nearly all values, so that a chain's first steps don't flatten the rest.
/// The range includes `least`. Values outside the range are clipped, as in the thesis's figure.
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

plot::Panel path_panel(const Hops& hops, const Asked& asked) {
  plot::Panel panel{
      .x_label = "x (ball diameters)", .y_label = "height (diameters)", .equal_aspect = true};
  // The target is a flat disc on the table. The table is the line on which the ball's centre
  // bounces.
  panel.series.push_back(
      plot::HorizontalLine{.y = 0, .color = plot::palette::k_grey, .dashed = false});
  panel.series.push_back(plot::Disc{.center = {asked.target, 0},
                                    .radius_x = std::max(asked.tolerance, 0.02),
                                    .radius_y = 0.06,
                                    .label = "target"});
  std::vector<plot::Point> path;
  std::vector<plot::Series> arrows;
  for (std::size_t i = 0; i + 1 < hops.segments.size(); ++i) {
    append_hop(hops.segments[i], hops.segments[i + 1].start_s, asked.diameter_m, path);
    const double tilt = hops.normal_rad[i];
    if (std::isnan(tilt)) continue;
    const plot::Point foot{hops.segments[i].position_m.x() / asked.diameter_m, 0};
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
  const scene::Scene scene = browse::required_scene(source);
  for (const std::size_t i : chosen) {
    plot::Panel panel = path_panel(read_hops(source, scene, i), asked);
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
          {.what = k_paths, .help = "paths of the ball, drawn as in the thesis"}};
}

pictures::Picture Ball2d::draw(std::string_view what, const archive::Source& source,
                               const pictures::DrawnPart& part) const {
  return {.figure = what == k_paths ? paths_figure(source, part) : trace_figure(source, part)};
}

}  // namespace sleight::world_plots
