#include "clients/world_plots/spelling.h"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "clients/analysis/request_numbers.h"
#include "clients/pictures/trace.h"
#include "common/archive/format.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::world_plots {
namespace {

/// Returns the number of designated bins, which is the number of balls and of the variable's rows.
std::uint64_t bins_to_fill(const archive::Source& source) {
  constexpr const char* k_of_balls = "active";
  const archive::Group* posterior = archive::find_group(source, archive::k_posterior);
  const archive::DatasetSpec* spec =
      posterior == nullptr ? nullptr : archive::find_dataset(*posterior, k_of_balls);
  // Dimensions: chain, draw and ball.
  if (spec == nullptr || spec->dims.size() != 3) {
    throw base::Error(
        base::ExitCode::bad_archive,
        fmt::format("{}: {}: expected one number per chain, draw and ball", source.name(),
                    archive::path_of(archive::k_posterior, k_of_balls)));
  }
  return spec->dims[2].size;
}

}  // namespace

std::string Spelling::world() const {
  return "spelling";
}

std::vector<pictures::WorldPlots::Kind> Spelling::kinds() const {
  return {{.what = std::string(pictures::k_trace)}};
}

pictures::Picture Spelling::draw(std::string_view /*what*/, const archive::Source& source,
                                 const pictures::DrawnPart& part) const {
  const analysis::RequestNumbers numbers(archive::summary_of(source).request_text, source.name());
  const double per_scan = numbers.find("sampler", "iterations_per_scan").value_or(1);
  const auto all = static_cast<double>(bins_to_fill(source));
  const std::string x_label = "iteration";
  plot::Panel filled{.title = "Designated bins that are filled",
                     .x_label = x_label,
                     .y_label = "filled bins",
                     .y_range = plot::Range{0, all + 0.5},
                     .height_share = 1.2};
  plot::Panel log_p{.title = "log p", .x_label = x_label, .y_label = "log p"};
  filled.series.push_back(plot::HorizontalLine{
      .y = all, .label = fmt::format("all {}", all), .color = plot::palette::k_green});
  const std::vector<std::uint64_t> chains = pictures::chains_to_draw(source, part.chain);
  for (std::size_t i = 0; i < chains.size(); ++i) {
    const pictures::TraceRange range{.chain = chains[i], .draws = part.draws};
    const auto along = [&](const char* variable, std::string label) {
      std::vector<plot::Point> points = pictures::trace(source, variable, range, 1);
      for (plot::Point& point : points)
        point.x *= per_scan;
      return plot::Steps{.points = std::move(points),
                         .color = plot::palette::series(i),
                         .label = std::move(label),
                         .width_px = 1};
    };
    filled.series.push_back(along("filled", fmt::format("chain {}", chains[i])));
    log_p.series.push_back(along("lp", ""));
  }
  return {.figure = {.title = "Balls that spell",
                     .width_px = 900,
                     .height_px = 560,
                     .panels = {std::move(filled), std::move(log_p)}}};
}

}  // namespace sleight::world_plots
