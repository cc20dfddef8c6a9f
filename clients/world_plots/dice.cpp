#include "clients/world_plots/dice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "clients/analysis/archive_rows.h"
#include "clients/browse/archives/kept_animations.h"
#include "common/archive/format.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::world_plots {
namespace {

constexpr std::uint64_t k_dice_max = 1000;  ///< above any request's maximum
constexpr double k_edge_sd = 3.75;          ///< where panels end
constexpr std::size_t k_curve_points = 81;
constexpr double k_row_px = 240;
constexpr std::size_t k_columns = 4;

double normal_density(double x) {
  return std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi);
}

/// Counts scores in the bins of control points.
std::vector<double> counted(std::span<const double> scores) {
  std::vector<double> counts(k_offset_bins);
  for (const double score : scores)
    ++counts.at(offset_bin_of(score));
  return counts;
}

/// Draws bars with area 1, and the prior. The outermost bins are drawn as wide as the others.
plot::Panel panel_of(const std::string& title, std::span<const double> counts) {
  plot::Panel panel{.title = title,
                    .x_label = "standard scores",
                    .y_label = "density",
                    .x_range = plot::Range{-k_edge_sd, k_edge_sd},
                    .legend = false};
  const double all = std::max(1.0, std::accumulate(counts.begin(), counts.end(), 0.0));
  for (std::size_t bin = 0; bin < counts.size(); ++bin) {
    const double low = k_offset_first_sd + (static_cast<double>(bin) - 1) * k_offset_step_sd;
    panel.series.push_back(
        plot::Rectangle{.low = {low, 0},
                        .high = {low + k_offset_step_sd, counts[bin] / all / k_offset_step_sd},
                        .color = plot::palette::k_sky,
                        .label = "kept animations"});
  }
  plot::Line curve{.color = plot::palette::k_vermillion, .label = "blind throws"};
  for (std::size_t i = 0; i < k_curve_points; ++i) {
    const double x = k_edge_sd * (2 * static_cast<double>(i) / (k_curve_points - 1) - 1);
    curve.points.push_back({x, normal_density(x)});
  }
  panel.series.push_back(curve);
  return panel;
}

/// A normally distributed vector of a die's start.
struct NormalVector {
  const char* variable;
  const char* name;  ///< for people
};
constexpr std::array<NormalVector, 3> k_normal_vectors{{{"start_position_m", "position"},
                                                        {"start_velocity_mps", "velocity"},
                                                        {"start_spin_radps", "spin"}}};
constexpr std::array k_axes{"x", "y", "z"};

/// Returns the number of dice of an archive: the rows of a start's variable.
std::uint64_t dice_of(const archive::Source& source) {
  const std::string name = fmt::format("{}_prior_sd", k_normal_vectors.front().variable);
  const archive::DatasetSpec* spec =
      archive::find_dataset(*archive::find_group(source, archive::k_prior), name);
  if (spec == nullptr || spec->dims.size() != 2 || spec->dims[0].size > k_dice_max) {
    throw base::Error(
        base::ExitCode::bad_archive,
        fmt::format("{}: {}: expected three numbers for each die, and at most {} dice",
                    source.name(), archive::path_of(archive::k_prior, name), k_dice_max));
  }
  return spec->dims[0].size;
}

/// Reads three numbers for each die.
std::vector<double> of_dice(const archive::Source& source, const std::string& name,
                            std::uint64_t dice) {
  return analysis::read_rows(source, archive::k_prior, name, 3, {.first = 0, .count = dice});
}

/// Whether control points of blind throws have random heights.
bool is_table_random(const archive::Source& source) {
  constexpr const char* k_squares = "offset_squares";
  const archive::DatasetSpec* spec =
      archive::find_dataset(*archive::find_group(source, archive::k_sample_stats_prior), k_squares);
  const std::uint64_t draws = spec == nullptr || spec->dims.size() != 2 ? 0 : spec->dims[1].size;
  if (spec == nullptr || spec->dims.size() != 2 || draws > archive::k_prior_draws_max) {
    throw base::Error(base::ExitCode::bad_archive,
                      fmt::format("{}: {}: expected one chain of at most {} draws", source.name(),
                                  archive::path_of(archive::k_sample_stats_prior, k_squares),
                                  archive::k_prior_draws_max));
  }
  if (draws < 2) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: this plot needs at least 2 draws from the prior, but the "
                                  "archive has {}; use the archive of the whole run",
                                  source.name(), draws));
  }
  const std::vector<double> squares = analysis::read_rows(
      source, archive::k_sample_stats_prior, k_squares, draws, {.first = 0, .count = 1});
  return std::ranges::any_of(squares, [](double sum) { return sum > 0; });
}

[[noreturn]] void refuse_number(const archive::Source& source, std::string_view variable,
                                std::string_view group = archive::k_animations) {
  throw base::Error(base::ExitCode::bad_archive,
                    fmt::format("{}: {}: values are impossible for a throw", source.name(),
                                archive::path_of(group, variable)));
}

/// Reads one variable of all animations.
std::vector<double> read_all(const archive::Source& source, std::string_view variable,
                             std::uint64_t width) {
  return analysis::read_rows(source, archive::k_animations, variable, width,
                             {.first = 0, .count = archive::summary_of(source).animations});
}

/// Limit above any throw's scores.
constexpr double k_score_max = 1e6;
constexpr double k_points_max = 1e9;  ///< limit above the control points of any throw

/// Reads the starts' scores. Returns, by animation, half of (the sum of the squared scores minus
/// the number of scores).
std::vector<double> read_start(const archive::Source& source, const DicePrior& prior,
                               std::span<const std::size_t> animations, DicePlausibility& found) {
  const std::uint64_t width = 3 * prior.dice;
  std::map<std::string, std::vector<double>> variables;
  std::vector<double> costs(animations.size());
  for (const StartComponent& component : prior.start) {
    std::vector<double>& values = variables[component.variable];
    if (values.empty()) values = read_all(source, component.variable, width);
    auto same = std::ranges::find(found.start, component.name, &DicePlausibility::Scores::name);
    if (same == found.start.end())
      same = found.start.insert(found.start.end(), {.name = component.name});
    for (std::size_t i = 0; i < animations.size(); ++i) {
      const double value = values[animations[i] * width + 3 * component.die + component.axis];
      const double score = (value - component.mean) / component.sd;
      if (!(std::fabs(score) <= k_score_max)) refuse_number(source, component.variable);
      same->scores.push_back(score);
      costs[i] += 0.5 * (score * score - 1);
    }
  }
  return costs;
}

/// Reads the table's scores and returns their costs, as read_start does for starts.
std::vector<double> read_table(const archive::Source& source,
                               std::span<const std::size_t> animations, DicePlausibility& found) {
  found.offsets.resize(k_offset_bins);
  const std::vector<double> offsets = read_all(source, "offsets", k_offset_bins);
  const std::vector<double> squares = browse::of_animations(source, "offset_squares");
  std::vector<double> costs;
  for (const std::size_t row : animations) {
    double points = 0;
    for (std::size_t bin = 0; bin < k_offset_bins; ++bin) {
      const double count = offsets[row * k_offset_bins + bin];
      if (!(count >= 0 && count <= k_points_max) || std::trunc(count) != count)
        refuse_number(source, "offsets");
      found.offsets[bin] += count;
      points += count;
    }
    if (!(squares[row] >= 0 && squares[row] <= k_score_max * k_score_max))
      refuse_number(source, "offset_squares");
    costs.push_back(0.5 * (squares[row] - points));
  }
  return costs;
}

/// Numbers the animations' lineages from 0. Returns how many there are.
std::size_t number_lineages(const archive::Source& source, std::span<const std::size_t> animations,
                            std::vector<std::size_t>& numbers) {
  const std::vector<double> chain = browse::of_animations(source, "chain");
  const std::vector<double> lineage = browse::of_animations(source, "lineage");
  std::map<std::pair<double, double>, std::size_t> seen;
  for (const std::size_t row : animations)
    numbers.push_back(seen.try_emplace({chain[row], lineage[row]}, seen.size()).first->second);
  return seen.size();
}

/// Computes a mean and its error, with sums over lineages as independent values.
PlausibilityCost cost_of(std::span<const double> costs, std::span<const std::size_t> lineage_of,
                         std::size_t lineages, double spread) {
  const auto count = static_cast<double>(costs.size());
  PlausibilityCost cost{.is_random = true, .spread = spread};
  cost.mean = std::accumulate(costs.begin(), costs.end(), 0.0) / count;
  std::vector<double> sums(lineages);
  for (std::size_t i = 0; i < costs.size(); ++i)
    sums[lineage_of[i]] += costs[i] - cost.mean;
  const double squares = std::inner_product(sums.begin(), sums.end(), sums.begin(), 0.0);
  const auto groups = static_cast<double>(lineages);
  cost.error = lineages < 2 ? std::numeric_limits<double>::quiet_NaN()
                            : std::sqrt(squares * groups / (groups - 1)) / count;
  return cost;
}

std::string shown(double mean, double error) {
  const std::string size = fmt::format("{:.2f}", std::fabs(mean));
  const std::string within = std::isnan(error) ? "" : fmt::format(" +- {:.2f}", error);
  return fmt::format("{}{} {}", size, within, mean < 0 ? "above" : "below");
}

std::string words_of(const PlausibilityCost& cost) {
  if (!cost.is_random) return "nothing is normally distributed";
  return fmt::format(
      "log probability {} the mean of blind throws (standard deviation of single throws: {:.2f})",
      shown(cost.mean, cost.error), cost.spread);
}

std::string verdict(const PlausibilityCost& cost) {
  constexpr double k_errors = 2;
  constexpr double k_exponent_max = 20;
  if (std::isnan(cost.error))
    return "A single lineage can't show how much of the difference is chance.";
  if (std::fabs(cost.mean) <= k_errors * cost.error)
    return "For this number of lineages, the total difference could be due to chance.";
  const double size = std::fabs(cost.mean);
  const std::string times =
      size > k_exponent_max ? fmt::format("e^{:.0f}", size) : fmt::format("{:.2g}", std::exp(size));
  return fmt::format("In total, {} typically have {} times the probability density of {}.",
                     cost.mean < 0 ? "these animations" : "blind throws", times,
                     cost.mean < 0 ? "blind throws" : "these animations");
}

}  // namespace

std::size_t offset_bin_of(double score) {
  constexpr double k_last = k_offset_bins - 1;
  const double bin = std::floor((score - k_offset_first_sd) / k_offset_step_sd) + 1;
  return static_cast<std::size_t>(std::clamp(bin, 0.0, k_last));
}

DicePrior dice_prior_of(const archive::Source& source) {
  for (const std::string_view group : {archive::k_prior, archive::k_sample_stats_prior}) {
    if (archive::find_group(source, group) == nullptr)
      throw base::Error(base::ExitCode::bad_archive,
                        fmt::format("{}: missing group {}", source.name(), group));
  }
  DicePrior prior{.dice = dice_of(source)};
  std::vector<std::vector<double>> means;
  std::vector<std::vector<double>> sds;
  for (const NormalVector& vector : k_normal_vectors) {
    means.push_back(of_dice(source, fmt::format("{}_prior_mean", vector.variable), prior.dice));
    sds.push_back(of_dice(source, fmt::format("{}_prior_sd", vector.variable), prior.dice));
  }
  for (std::uint64_t die = 0; die < prior.dice; ++die) {
    for (std::size_t i = 0; i < k_normal_vectors.size(); ++i) {
      for (std::uint64_t axis = 0; axis < k_axes.size(); ++axis) {
        const double sd = sds[i].at(3 * die + axis);
        const double mean = means[i].at(3 * die + axis);
        // `sd` is 0 for a fixed number, and NaN for a number that isn't normal.
        if (!(sd > 0)) continue;
        if (!std::isfinite(sd) || !std::isfinite(mean)) {
          refuse_number(source, fmt::format("{}_prior_mean", k_normal_vectors[i].variable),
                        archive::k_prior);
        }
        prior.start.push_back({.variable = k_normal_vectors[i].variable,
                               .name = fmt::format("{} {}", k_normal_vectors[i].name, k_axes[axis]),
                               .die = die,
                               .axis = axis,
                               .mean = mean,
                               .sd = sd});
      }
    }
  }
  prior.is_table_random = is_table_random(source);
  return prior;
}

DicePlausibility dice_plausibility(const archive::Source& source, const DicePrior& prior,
                                   std::optional<std::uint64_t> chain) {
  if (browse::drawn_group(source) == archive::k_finds) {
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("{}: a search found the animations, so they are not in the model's "
                    "proportions, and their plausibility can't be compared with the model",
                    source.name()));
  }
  const std::vector<std::size_t> animations =
      browse::choose_animations(source, chain, std::numeric_limits<std::size_t>::max());
  DicePlausibility found{.animations = animations.size()};
  std::vector<std::size_t> lineage_of;
  found.lineages = number_lineages(source, animations, lineage_of);
  const archive::Group* tempering = archive::find_group(source, archive::k_tempering);
  found.has_weights =
      tempering != nullptr && archive::find_dataset(*tempering, "log_weight") != nullptr;
  std::vector<double> costs(animations.size());
  const auto add = [&](const std::vector<double>& of_part, double numbers) {
    for (std::size_t i = 0; i < costs.size(); ++i)
      costs[i] += of_part[i];
    return cost_of(of_part, lineage_of, found.lineages, std::sqrt(0.5 * numbers));
  };
  double numbers = 0;
  if (!prior.start.empty()) {
    const auto components = static_cast<double>(prior.start.size());
    found.start_cost = add(read_start(source, prior, animations, found), components);
    numbers += components;
  }
  if (prior.is_table_random) {
    const std::vector<double> of_table = read_table(source, animations, found);
    const double points = std::accumulate(found.offsets.begin(), found.offsets.end(), 0.0) /
                          static_cast<double>(animations.size());
    found.table_cost = add(of_table, points);
    numbers += points;
  }
  found.cost = cost_of(costs, lineage_of, found.lineages, std::sqrt(0.5 * numbers));
  return found;
}

plot::Figure plausibility_figure(const DicePlausibility& found, const DicePrior& prior) {
  plot::Figure figure{
      .title = fmt::format(
          "{} kept animations (bars; end bars include outliers) and blind throws (curve)",
          found.animations),
      .height_px = 0,
      .panels = {}};
  if (prior.is_table_random) figure.panels.push_back(panel_of("table heights", found.offsets));
  for (const DicePlausibility::Scores& component : found.start)
    figure.panels.push_back(panel_of(component.name, counted(component.scores)));
  figure.columns = std::clamp<std::size_t>(figure.panels.size(), 1, k_columns);
  const std::size_t rows = (figure.panels.size() + figure.columns - 1) / figure.columns;
  figure.height_px = k_row_px * static_cast<double>(std::max<std::size_t>(1, rows));
  return figure;
}

std::string plausibility_words(const DicePlausibility& found) {
  return fmt::format(
      "Bars: {} kept animations of {} lineages{}; the first and last bars include all values "
      "outside the plot. Curve: blind throws.\n"
      "starts: {}\n"
      "table:  {}\n"
      "{}\n",
      found.animations, found.lineages, found.has_weights ? ", without their weights" : "",
      words_of(found.start_cost), words_of(found.table_cost), verdict(found.cost));
}

std::string Dice::world() const {
  return "dice";
}

std::vector<pictures::WorldPlots::Kind> Dice::kinds() const {
  return {{.what = "plausibility", .help = "comparison of starts and tables with blind throws"}};
}

pictures::Picture Dice::draw(std::string_view /*what*/, const archive::Source& source,
                             const pictures::DrawnPart& part) const {
  const DicePrior prior = dice_prior_of(source);
  if (prior.start.empty() && !prior.is_table_random) {
    throw base::Error(base::ExitCode::environment,
                      fmt::format("{}: nothing to plot, because neither the starts nor the table "
                                  "heights are normally distributed",
                                  source.name()));
  }
  const DicePlausibility found = dice_plausibility(source, prior, part.chain);
  return {.figure = plausibility_figure(found, prior), .words = plausibility_words(found)};
}

}  // namespace sleight::world_plots
