// `sleight-tables-3`: tables 3.1 and 3.2 and figures 3.8 and 3.10 of the thesis, made again.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "clients/plot/save.h"
#include "common/base/error.h"
#include "tests/thesis/tables_3/experiments.h"

namespace {

using sleight::thesis::Experiment;
using sleight::thesis::Row;
namespace plot = sleight::plot;

struct Table {
  std::string name;
  std::string file;    ///< of the thesis's numbers
  std::string figure;  ///< its number
  std::string title;
  Experiment experiment;
};

/// Columns of a row of ours, and beside them the thesis's if it has such a row.
void print(const Row& row, const std::vector<Row>& thesis) {
  fmt::print("| {} | {:.0f} | {:.0f} | {:.5f} | {:.4g} | {:.0f} | {:.5f} | {:.4g} | {:.1f} |",
             row.n, row.collisions, row.sync.events, row.sync.ms_per_event(), row.sync.total_s,
             row.async.events, row.async.ms_per_event(), row.async.total_s, row.speed_up());
  if (thesis.empty()) {
    fmt::print("\n");
    return;
  }
  const auto same = std::ranges::find(thesis, row.n, &Row::n);
  if (same == thesis.end()) {
    fmt::print(" | | | | |\n");
  } else {
    fmt::print(" {:.0f} | {:.4f} | {:.0f} | {:.4f} | {:.1f} |\n", same->sync.events,
               same->sync.ms_per_event(), same->async.events, same->async.ms_per_event(),
               same->speed_up());
  }
}

plot::Line speed_ups(const std::vector<Row>& rows, plot::Color color, const std::string& label) {
  plot::Line line{.color = color, .label = label};
  for (const Row& row : rows)
    line.points.push_back({static_cast<double>(row.n), row.speed_up()});
  return line;
}

void draw(const Table& table, const std::vector<Row>& rows, const std::vector<Row>& thesis,
          const std::string& folder) {
  plot::Panel panel{.x_label = "moving bodies", .y_label = "synchronous / asynchronous time"};
  const auto add = [&](const plot::Line& line) {
    panel.series.emplace_back(line);
    panel.series.emplace_back(
        plot::Markers{.points = line.points, .color = line.color, .label = line.label});
  };
  add(speed_ups(rows, plot::palette::k_blue, "Sleight"));
  if (!thesis.empty()) add(speed_ups(thesis, plot::palette::k_vermillion, "thesis"));
  const plot::Figure figure{
      .title = table.title, .width_px = 640, .height_px = 400, .panels = {panel}};
  plot::save(figure, folder + "/figure_" + table.figure + ".svg");
}

void reproduce(const Table& table, const std::string& reference, const std::string& out) {
  const std::vector<Row> thesis = sleight::thesis::read_thesis_table(reference + "/" + table.file);
  fmt::print(
      "\n{}, {} seeds\n\n| n | collisions | sync events | ms/event | s | async events | "
      "ms/event | s | speed-up |",
      table.name, table.experiment.seeds);
  if (!thesis.empty())
    fmt::print(" thesis: sync events | ms/event | async events | ms/event | speed-up |");
  fmt::print("\n|");
  for (int column = 0; column < (thesis.empty() ? 9 : 14); ++column)
    fmt::print("--:|");
  fmt::print("\n");
  std::vector<Row> rows;
  for (const std::uint32_t n : table.experiment.sizes) {
    rows.push_back(sleight::thesis::measure(table.experiment, n));
    print(rows.back(), thesis);
    std::fflush(stdout);
  }
  draw(table, rows, thesis, out);
}

struct Arguments {
  std::string reference = "../shared/reference";
  std::string out = "docs/figures";
  std::uint64_t seeds = 0;
  bool quick = false;
};

void reproduce_all(const Arguments& arguments) {
  Table box{.name = "Table 3.1: polyhedra in a box, 1000 s simulated",
            .file = "table_3_1_boxed_polyhedra.csv",
            .figure = "3_8",
            .title = "Polyhedra in a box",
            .experiment = sleight::thesis::boxed_polyhedra(1000)};
  Table funnel{.name = "Table 3.2: grains through a funnel",
               .file = "table_3_2_hourglass.csv",
               .figure = "3_10",
               .title = "Grains through a funnel",
               .experiment = sleight::thesis::hourglass(1000)};
  if (arguments.quick) {
    box.name = "Table 3.1, quick: 20 s simulated";
    box.experiment = sleight::thesis::boxed_polyhedra(20);
    box.experiment.sizes = {1, 8, 64};
    funnel.name = "Table 3.2, quick: 2 s simulated";
    funnel.experiment = sleight::thesis::hourglass(2);
    funnel.experiment.sizes = {10, 20};
    box.experiment.seeds = 1;
    funnel.experiment.seeds = 1;
  }
  for (Table* table : {&box, &funnel}) {
    if (arguments.seeds > 0) table->experiment.seeds = arguments.seeds;
    reproduce(*table, arguments.reference, arguments.out);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Tables 3.1 and 3.2 of the thesis on stdout, figures 3.8 and 3.10 as SVG."};
  app.name("sleight-tables-3");
  Arguments arguments;
  app.add_option("--reference", arguments.reference,
                 "Folder of the thesis's tables as CSV; without them ours alone")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "Folder of the figures")->capture_default_str();
  app.add_option("--seeds", arguments.seeds, "Simulations per row; 0: as the thesis, 5 and 10")
      ->capture_default_str();
  app.add_flag("--quick", arguments.quick, "Few rows, a short time: that it works");
  app.footer("From the project's root:\n  build/release/bin/sleight-tables-3");
  CLI11_PARSE(app, argc, argv);
  try {
    reproduce_all(arguments);
  } catch (const sleight::base::Error& error) {
    fmt::print(stderr, "sleight-tables-3: {}\n", error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "sleight-tables-3: {}\n", error.what());
    return static_cast<int>(sleight::base::ExitCode::bug);
  }
  return 0;
}
