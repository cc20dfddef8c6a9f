#include "clients/cli/plot_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "clients/cli/ball_2d_figures.h"
#include "clients/cli/output.h"
#include "clients/cli/request_numbers.h"
#include "clients/cli/trace.h"
#include "clients/plot/save.h"
#include "clients/plot/terminal.h"
#include "common/archive/hdf5/guarded.h"
#include "common/archive/hdf5/reader.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

/// Any world's outcomes and log p along its chains.
plot::Figure plain_trace(const archive::Source& source, const PlotOptions& options) {
  const archive::Summary summary = archive::summary_of(source);
  plot::Figure figure{.title = summary.world, .height_px = 0, .panels = {}};
  std::vector<std::string> names = outcome_names(source);
  names.emplace_back("lp");
  const std::string step = scan_label(RequestNumbers(summary.request_text, source.name()));
  const std::uint64_t chains = options.chain ? 1 : stats_size(source, "chain");
  for (const std::string& name : names) {
    plot::Panel panel{.title = name, .x_label = step, .y_label = name};
    for (std::uint64_t i = 0; i < std::min<std::uint64_t>(chains, 6); ++i) {
      const std::uint64_t chain = options.chain.value_or(i);
      panel.series.push_back(
          plot::Steps{.points = trace(source, name, {.chain = chain, .draws = options.draws}, 1),
                      .color = plot::palette::series(i),
                      .label = fmt::format("chain {}", chain),
                      .width_px = 1});
    }
    figure.panels.push_back(std::move(panel));
    figure.height_px += 280;
  }
  return figure;
}

plot::Figure figure_of(const archive::Source& source, const PlotOptions& options) {
  const bool ball = archive::summary_of(source).world == "ball_2d";
  if (options.what == "paths") {
    if (ball) return ball_2d_paths(source, options.chain, options.count);
    throw base::Error(base::ExitCode::usage, "paths can be drawn for ball_2d archives only");
  }
  return ball ? ball_2d_trace(source, options.chain, options.draws) : plain_trace(source, options);
}

void draw_on_terminal(const plot::Figure& figure) {
  plot::TerminalOptions terminal = plot::detect_terminal(STDOUT_FILENO);
  terminal.rows = std::max<std::size_t>(14, terminal.rows / figure.panels.size());
  for (const plot::Panel& panel : figure.panels) {
    fmt::print("{}\n", plot::to_terminal(panel, terminal));
  }
}

}  // namespace

int plot_archive(const PlotOptions& options) {
  if (!options.output.empty()) refuse_same_file(options.path, options.output);
  const auto draw = [&] {
    const auto source = archive::hdf5::open_file(options.path);
    const plot::Figure figure = figure_of(*source, options);
    if (options.output.empty()) {
      draw_on_terminal(figure);
    } else {
      plot::save(figure, options.output);
      fmt::print("{}\n", options.output);
    }
    return static_cast<int>(base::ExitCode::ok);
  };
  return archive::hdf5::guarded(options.path, {}, [&] { return with_results(draw); });
}

}  // namespace sleight::cli
