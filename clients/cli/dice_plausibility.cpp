#include "clients/cli/dice_plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include "clients/cli/kept_animations.h"
#include "clients/cli/trace.h"
#include "common/archive/format.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

using plot::Point;

constexpr double k_edge_sd = 4;  ///< panels end there
constexpr std::size_t k_curve_points = 81;
constexpr double k_row_px = 240;
constexpr std::size_t k_columns = 4;

double normal_density(double x) {
  return std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi);
}

/// Scores by the bins of control points.
std::vector<double> counted(std::span<const double> scores, const DicePrior& prior) {
  std::vector<double> counts(prior.offset_bins);
  const double last = static_cast<double>(prior.offset_bins) - 1;
  for (const double score : scores) {
    const double bin = std::floor((score - prior.offset_first_sd) / prior.offset_step_sd) + 1;
    ++counts[static_cast<std::size_t>(std::clamp(bin, 0.0, last))];
  }
  return counts;
}

/// Bars whose area is 1, and the prior. The outermost bins are drawn as wide as others.
plot::Panel panel_of(const std::string& title, std::span<const double> counts,
                     const DicePrior& prior) {
  plot::Panel panel{.title = title,
                    .x_label = "standard scores",
                    .y_label = "density",
                    .x_range = plot::Range{-k_edge_sd, k_edge_sd},
                    .legend = false};
  const double all = std::max(1.0, std::accumulate(counts.begin(), counts.end(), 0.0));
  for (std::size_t bin = 0; bin < counts.size(); ++bin) {
    const double low =
        prior.offset_first_sd + (static_cast<double>(bin) - 1) * prior.offset_step_sd;
    panel.series.push_back(plot::Rectangle{
        .low = {low, 0},
        .high = {low + prior.offset_step_sd, counts[bin] / all / prior.offset_step_sd},
        .color = plot::palette::k_sky,
        .label = "satisfying animations"});
  }
  plot::Line curve{.color = plot::palette::k_vermillion, .label = "blind throws"};
  for (std::size_t i = 0; i < k_curve_points; ++i) {
    const double x = k_edge_sd * (2 * static_cast<double>(i) / (k_curve_points - 1) - 1);
    curve.points.push_back({x, normal_density(x)});
  }
  panel.series.push_back(curve);
  return panel;
}

[[noreturn]] void refuse_number(const archive::Source& source, std::string_view variable) {
  throw base::Error(base::ExitCode::bad_archive,
                    fmt::format("{}: {}: it has values that no throw has", source.name(),
                                archive::path_of(archive::k_animations, variable)));
}

/// One variable of all animations.
std::vector<double> read_all(const archive::Source& source, std::string_view variable,
                             std::uint64_t width) {
  return read_rows(source, archive::k_animations, variable, width,
                   {.first = 0, .count = archive::summary_of(source).animations});
}

/// Reads scores of the starts; the sum of their squares.
double read_start(const archive::Source& source, const DicePrior& prior,
                  std::span<const std::size_t> animations, DicePlausibility& found) {
  double squares = 0;
  for (const StartComponent& component : prior.start) {
    const std::uint64_t width = 3 * prior.dice;
    const std::vector<double> values = read_all(source, component.variable, width);
    auto same = std::ranges::find(found.start, component.name, &DicePlausibility::Scores::name);
    if (same == found.start.end())
      same = found.start.insert(found.start.end(), {.name = component.name});
    for (const std::size_t row : animations) {
      const double value = values[row * width + 3 * component.die + component.axis];
      const double score = (value - component.mean) / component.sd;
      if (!std::isfinite(score)) refuse_number(source, component.variable);
      same->scores.push_back(score);
      squares += score * score;
    }
  }
  return squares;
}

std::string cost_words(double cost, double spread) {
  const char* way = cost < 0 ? "above" : "below";
  return fmt::format("log probability {:.2f} {} blind throws' on average (theirs differ by {:.2f})",
                     std::fabs(cost), way, spread);
}

}  // namespace

DicePlausibility dice_plausibility(const archive::Source& source, const DicePrior& prior,
                                   std::optional<std::uint64_t> chain) {
  const std::vector<std::size_t> animations =
      choose_animations(source, chain, std::numeric_limits<std::size_t>::max());
  const auto count = static_cast<double>(animations.size());
  DicePlausibility found{.animations = animations.size()};
  const double start_squares = read_start(source, prior, animations, found);
  const auto components = static_cast<double>(prior.start.size());
  found.start_cost = 0.5 * (start_squares / count - components);
  found.start_spread = std::sqrt(0.5 * components);
  if (!prior.is_table_random) return found;
  found.offsets.resize(prior.offset_bins);
  const std::vector<double> offsets = read_all(source, "offsets", prior.offset_bins);
  const std::vector<double> all_squares = of_animations(source, "offset_squares");
  double squares = 0;
  for (const std::size_t row : animations) {
    if (!(all_squares[row] >= 0) || !std::isfinite(all_squares[row]))
      refuse_number(source, "offset_squares");
    squares += all_squares[row];
    for (std::size_t bin = 0; bin < prior.offset_bins; ++bin) {
      const double points = offsets[row * prior.offset_bins + bin];
      if (!(points >= 0) || !std::isfinite(points)) refuse_number(source, "offsets");
      found.offsets[bin] += points;
    }
  }
  const double points = std::accumulate(found.offsets.begin(), found.offsets.end(), 0.0);
  found.table_cost = 0.5 * (squares - points) / count;
  found.table_spread = std::sqrt(0.5 * points / count);
  return found;
}

plot::Figure plausibility_figure(const DicePlausibility& found, const DicePrior& prior) {
  plot::Figure figure{.title = fmt::format("{} satisfying animations (bars) beside blind throws "
                                           "(curve)",
                                           found.animations),
                      .height_px = 0,
                      .panels = {}};
  if (prior.is_table_random)
    figure.panels.push_back(panel_of("table heights", found.offsets, prior));
  for (const DicePlausibility::Scores& component : found.start)
    figure.panels.push_back(panel_of(component.name, counted(component.scores, prior), prior));
  figure.columns = std::clamp<std::size_t>(figure.panels.size(), 1, k_columns);
  const std::size_t rows = (figure.panels.size() + figure.columns - 1) / figure.columns;
  figure.height_px = k_row_px * static_cast<double>(std::max<std::size_t>(1, rows));
  return figure;
}

std::string plausibility_words(const DicePlausibility& found) {
  const double cost = found.start_cost + found.table_cost;
  return fmt::format(
      "starts: {}\ntable:  {}\n"
      "So a satisfying animation is on average {:.3g} times {} probable than a blind throw.\n",
      cost_words(found.start_cost, found.start_spread),
      cost_words(found.table_cost, found.table_spread), std::exp(std::fabs(cost)),
      cost < 0 ? "more" : "less");
}

}  // namespace sleight::cli
