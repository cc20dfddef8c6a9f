#include "clients/cli/plot_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "clients/cli/animation_figures.h"
#include "clients/cli/ball_2d_figures.h"
#include "clients/cli/dice_figures.h"
#include "clients/cli/output.h"
#include "clients/cli/request_numbers.h"
#include "clients/cli/spelling_figures.h"
#include "clients/cli/trace.h"
#include "clients/plot/save.h"
#include "clients/plot/terminal.h"
#include "common/archive/format.h"
#include "common/archive/hdf5/guarded.h"
#include "common/archive/remote/remote_source.h"
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
  const std::vector<std::uint64_t> chains = chains_to_draw(source, options.chain);
  for (const std::string& name : names) {
    plot::Panel panel{.title = name, .x_label = step, .y_label = name};
    for (std::size_t i = 0; i < chains.size(); ++i) {
      panel.series.push_back(plot::Steps{
          .points = trace(source, name, {.chain = chains[i], .draws = options.draws}, 1),
          .color = plot::palette::series(i),
          .label = fmt::format("chain {}", chains[i]),
          .width_px = 1});
    }
    figure.panels.push_back(std::move(panel));
    figure.height_px += 280;
  }
  return figure;
}

/// What a world's reader makes of the archive's request.
template <class Read>
auto read_of(const archive::Source& source, const Read& read, const char* things) {
  auto scene = read(archive::summary_of(source).request_text);
  if (scene) return std::move(scene).value();
  throw base::Error(base::ExitCode::bad_archive, fmt::format("{}: its request is none of {}: {}",
                                                             source.name(), things, scene.error()));
}

SpellingBox spelling_box_of(const archive::Source& source, const WorldReaders& readers) {
  return read_of(source, readers.spelling_box, "balls that spell");
}

/// A picture, and words to go with it.
struct Picture {
  plot::Figure figure;
  std::string words{};
};

Picture plausibility_of(const archive::Source& source, const PlotOptions& options,
                        const WorldReaders& readers) {
  const std::string world = archive::summary_of(source).world;
  if (world != "dice") {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("plausibility can be drawn of dice archives only, and {} is of "
                                  "the world {}",
                                  source.name(), world));
  }
  const DicePrior prior = read_of(source, readers.dice_prior, "dice");
  if (prior.start.empty() && !prior.is_table_random) {
    throw base::Error(
        base::ExitCode::environment,
        fmt::format("{}: of its throws nothing is normally distributed: no component of a start, "
                    "no heights of the table",
                    source.name()));
  }
  const DicePlausibility found = dice_plausibility(source, prior, options.chain);
  return {.figure = plausibility_figure(found, prior), .words = plausibility_words(found)};
}

plot::Figure figure_of(const archive::Source& source, const PlotOptions& options,
                       const WorldReaders& readers) {
  const archive::Summary summary = archive::summary_of(source);
  const std::string& world = summary.world;
  if (options.what == "trace" && summary.scans == 0 && summary.finds.found > 0) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: its animations were found by search, which leaves no trace; "
                                  "try --what animations",
                                  source.name()));
  }
  if (options.what == "paths") {
    if (world == "ball_2d") return ball_2d_paths(source, options.chain, options.count);
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("paths can be drawn of ball_2d archives only, and {} is of the "
                    "world {}{}",
                    source.name(), world,
                    world == "spelling" || world == "dice" ? "; try --what animations" : ""));
  }
  if (options.what == "animations") {
    // Archives of formats 1 and 2 have no scene: what they are of has to be known.
    const bool has_scene = archive::find_group(source, archive::k_scene) != nullptr;
    if (!has_scene && world == "spelling") {
      // A terminal's dots are too few for the frames.
      return spelling_animations(
          source, spelling_box_of(source, readers),
          {.chain = options.chain, .count = options.count, .frames = !options.output.empty()});
    }
    if (!has_scene && world == "dice") {
      return dice_animations(
          source, read_of(source, readers.dice_scene, "dice"),
          {.chain = options.chain, .count = options.count, .front = !options.output.empty()});
    }
    return animation_figure(
        source, {.chain = options.chain, .count = options.count, .whole = !options.output.empty()});
  }
  if (world == "ball_2d") return ball_2d_trace(source, options.chain, options.draws);
  if (world == "spelling") {
    return spelling_trace(source, spelling_box_of(source, readers), options.chain, options.draws);
  }
  return plain_trace(source, options);
}

void draw_on_terminal(const plot::Figure& figure) {
  plot::TerminalOptions terminal = plot::detect_terminal(STDOUT_FILENO);
  terminal.rows = std::max<std::size_t>(14, terminal.rows / figure.panels.size());
  for (const plot::Panel& panel : figure.panels) {
    fmt::print("{}\n", plot::to_terminal(panel, terminal));
  }
}

}  // namespace

int plot_archive(const PlotOptions& options, const WorldReaders& readers) {
  if (!options.output.empty()) refuse_same_file(options.path, options.output);
  const plot::Notes notes = plot::notes_of(options.notes);
  if (options.output.empty() && !notes.empty())
    throw base::Error(base::ExitCode::usage, "--note goes with -o FILE.svg");
  const auto draw = [&] {
    const auto source = archive::remote::open_remote(options.path);
    const Picture picture = options.what == "plausibility"
                                ? plausibility_of(*source, options, readers)
                                : Picture{.figure = figure_of(*source, options, readers)};
    if (options.output.empty()) {
      draw_on_terminal(picture.figure);
    } else {
      plot::save(picture.figure, options.output, {.notes = notes});
      fmt::print("{}\n", options.output);
    }
    fmt::print("{}", picture.words);
    return static_cast<int>(base::ExitCode::ok);
  };
  return archive::hdf5::guarded(options.path, {}, [&] { return with_results(draw); });
}

}  // namespace sleight::cli
