#include "clients/cli/plot_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "clients/analysis/archive_rows.h"
#include "clients/analysis/request_numbers.h"
#include "clients/pictures/animation_figures.h"
#include "clients/pictures/trace.h"
#include "clients/plot/save.h"
#include "clients/plot/terminal.h"
#include "clients/terminal/output.h"
#include "common/archive/format.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::cli {
namespace {

/// Draws outcomes and log p along chains, for any world.
plot::Figure plain_trace(const archive::Source& source, const PlotOptions& options) {
  const archive::Summary summary = archive::summary_of(source);
  plot::Figure figure{.title = summary.world, .height_px = 0, .panels = {}};
  std::vector<std::string> names = analysis::outcome_names(source);
  names.emplace_back("lp");
  const std::string step =
      scan_label(analysis::RequestNumbers(summary.request_text, source.name()));
  const std::vector<std::uint64_t> chains = pictures::chains_to_draw(source, options.chain);
  for (const std::string& name : names) {
    plot::Panel panel{.title = name, .x_label = step, .y_label = name};
    for (std::size_t i = 0; i < chains.size(); ++i) {
      panel.series.push_back(plot::Steps{
          .points = pictures::trace(source, name, {.chain = chains[i], .draws = options.draws}, 1),
          .color = plot::palette::series(i),
          .label = fmt::format("chain {}", chains[i]),
          .width_px = 1});
    }
    figure.panels.push_back(std::move(panel));
    figure.height_px += 280;
  }
  return figure;
}

/// Returns the world's own plots. Null if the world's own plots don't include `what`.
const pictures::WorldPlots* plots_for(const pictures::PlotsOfWorlds& worlds, std::string_view world,
                                      std::string_view what) {
  for (const auto& plots : worlds) {
    if (plots->world() != world) continue;
    const auto kinds = plots->kinds();
    if (std::ranges::find(kinds, what, &pictures::WorldPlots::Kind::what) != kinds.end())
      return plots.get();
  }
  return nullptr;
}

/// A choice of `--what` that only some worlds have.
struct OwnWhat {
  pictures::WorldPlots::Kind kind{};
  std::vector<std::string> worlds{};
};

std::vector<OwnWhat> own_whats_of(const pictures::PlotsOfWorlds& worlds) {
  std::vector<OwnWhat> found;
  for (const auto& plots : worlds) {
    for (pictures::WorldPlots::Kind& kind : plots->kinds()) {
      if (kind.what == pictures::k_trace || kind.what == pictures::k_drawn_animations) continue;
      const auto same = std::ranges::find(
          found, kind.what, [](const OwnWhat& one) -> const auto& { return one.kind.what; });
      if (same == found.end()) {
        found.push_back({.kind = std::move(kind), .worlds = {plots->world()}});
      } else {
        same->worlds.push_back(plots->world());
      }
    }
  }
  return found;
}

[[noreturn]] void refuse_what(const archive::Source& source, const std::string& what,
                              std::string_view world, const pictures::PlotsOfWorlds& worlds) {
  std::vector<std::string> whose;
  for (const OwnWhat& own : own_whats_of(worlds)) {
    if (own.kind.what == what) whose = own.worlds;
  }
  throw base::Error(base::ExitCode::usage,
                    fmt::format("--what {} works only for archives of world {}, but {} has world "
                                "{}; try --what animations",
                                what, fmt::join(whose, " and "), source.name(), world));
}

void draw_on_terminal(const plot::Figure& figure) {
  plot::TerminalOptions terminal = plot::detect_terminal(STDOUT_FILENO);
  terminal.rows = std::max<std::size_t>(14, terminal.rows / figure.panels.size());
  for (const plot::Panel& panel : figure.panels) {
    fmt::print("{}\n", plot::to_terminal(panel, terminal));
  }
}

}  // namespace

std::vector<std::string> whats_of(const pictures::PlotsOfWorlds& worlds) {
  std::vector<std::string> whats{std::string(pictures::k_trace),
                                 std::string(pictures::k_drawn_animations)};
  for (const OwnWhat& own : own_whats_of(worlds))
    whats.push_back(own.kind.what);
  return whats;
}

std::string help_of_whats(const pictures::PlotsOfWorlds& worlds) {
  std::string help = fmt::format(
      "{}: outcome and log p (default if there are draws); {}: motion (default otherwise)",
      pictures::k_trace, pictures::k_drawn_animations);
  for (const OwnWhat& own : own_whats_of(worlds)) {
    help += fmt::format("; {}: {} ({})", own.kind.what, own.kind.help, fmt::join(own.worlds, ", "));
  }
  return help;
}

pictures::Picture picture_of(const archive::Source& source, const PlotOptions& options, bool whole,
                             const pictures::PlotsOfWorlds& worlds) {
  const archive::Summary summary = archive::summary_of(source);
  const bool has_draws = summary.scans > 0 || summary.finds.found == 0;
  const std::string what =
      !options.what.empty()
          ? options.what
          : std::string(has_draws ? pictures::k_trace : pictures::k_drawn_animations);
  if (what == pictures::k_trace && summary.scans == 0 && summary.finds.found > 0) {
    throw base::Error(
        base::ExitCode::usage,
        fmt::format(
            "{}: the animations come from a search, which has no trace; try --what animations",
            source.name()));
  }
  if (const pictures::WorldPlots* own = plots_for(worlds, summary.world, what)) {
    return own->draw(what, source,
                     {.chain = options.chain, .draws = options.draws, .count = options.count});
  }
  if (what == pictures::k_trace) return {.figure = plain_trace(source, options)};
  if (what == pictures::k_drawn_animations) {
    return {.figure = pictures::animation_figure(
                source, {.chain = options.chain, .count = options.count, .whole = whole})};
  }
  refuse_what(source, what, summary.world, worlds);
}

int plot_archive(const PlotOptions& options, const pictures::PlotsOfWorlds& worlds) {
  if (!options.output.empty()) terminal::refuse_same_file(options.path, options.output);
  const plot::Notes notes = plot::notes_of(options.notes);
  if (options.output.empty() && !notes.empty())
    throw base::Error(base::ExitCode::usage, "--note requires -o FILE.svg");
  const pictures::Picture picture = picture_of(*archive::remote::open_remote(options.path), options,
                                               !options.output.empty(), worlds);
  if (options.output.empty()) {
    draw_on_terminal(picture.figure);
  } else {
    plot::save(picture.figure, options.output, {.notes = notes});
    fmt::print("{}\n", options.output);
  }
  fmt::print("{}", picture.words);
  return static_cast<int>(base::ExitCode::ok);
}

}  // namespace sleight::cli
