// `sleight-tables-3`: reproduces tables 3.1 and 3.2 and figures 3.8 and 3.10 of the thesis.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "clients/plot/save.h"
#include "common/base/error.h"
#include "common/base/version.h"
#include "tests/thesis/tables_3/experiments.h"

namespace {

using sleight::thesis::Experiment;
using sleight::thesis::Row;
namespace plot = sleight::plot;

struct Arguments {
  std::string reference = "tests/thesis/tables_3";
  std::string out = "docs/figures";
  std::uint64_t seeds = 0;
  std::string only;                ///< table; empty: both
  std::vector<std::string> notes;  ///< of each picture (clients/plot/notes.h)
  bool quick = false;
};

struct Table {
  std::string number;
  std::string name;
  std::string file;    ///< of the thesis's numbers (thesis_table.h)
  std::string figure;  ///< its number
  std::string title;
  Experiment experiment;
};

void print(const Row& row, const Row& thesis) {
  fmt::print(
      "| {} | {:.0f} | {:.0f} | {:.5f} | {:.4g} | {:.0f} | {:.5f} | {:.4g} | {:.1f} | {:.0f} | "
      "{:.4f} | {:.0f} | {:.4f} | {:.1f} |\n",
      row.n, row.collisions, row.sync.events, row.sync.ms_per_event(), row.sync.total_s,
      row.async.events, row.async.ms_per_event(), row.async.total_s, row.speed_up(),
      thesis.sync.events, thesis.sync.ms_per_event(), thesis.async.events,
      thesis.async.ms_per_event(), thesis.speed_up());
}

plot::Line speed_ups(const std::vector<Row>& rows, plot::Color color, const std::string& label) {
  plot::Line line{.color = color, .label = label};
  for (const Row& row : rows)
    line.points.push_back({static_cast<double>(row.n), row.speed_up()});
  return line;
}

void draw(const Table& table, const std::vector<Row>& rows, const std::vector<Row>& thesis,
          const Arguments& arguments) {
  plot::Panel panel{.x_label = "moving bodies", .y_label = "synchronous / asynchronous time"};
  const auto add = [&](const plot::Line& line) {
    panel.series.emplace_back(line);
    panel.series.emplace_back(
        plot::Markers{.points = line.points, .color = line.color, .label = line.label});
  };
  add(speed_ups(rows, plot::palette::k_blue, "Sleight"));
  add(speed_ups(thesis, plot::palette::k_vermillion, "thesis"));
  const plot::Figure figure{
      .title = table.title, .width_px = 640, .height_px = 400, .panels = {panel}};
  plot::save(figure, arguments.out + "/figure_" + table.figure + ".svg",
             {.notes = plot::notes_of(arguments.notes)});
}

void reproduce(const Table& table, const Arguments& arguments) {
  const std::string reference = arguments.reference + "/" + table.file;
  const std::vector<Row> thesis = sleight::thesis::read_thesis_table(reference);
  fmt::print(
      "\n{}, {} seeds\n\n| n | collisions | sync events | ms/event | s | async events | ms/event "
      "| s | speed-up | thesis: sync events | ms/event | async events | ms/event | speed-up |\n"
      "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
      table.name, table.experiment.seeds);
  std::vector<Row> rows;
  for (const std::uint32_t n : table.experiment.sizes) {
    const Row& beside = sleight::thesis::row_of(thesis, n, reference);
    rows.push_back(sleight::thesis::measure(table.experiment, n));
    print(rows.back(), beside);
    std::fflush(stdout);
  }
  draw(table, rows, thesis, arguments);
}

void reproduce_all(const Arguments& arguments) {
  (void)plot::notes_of(arguments.notes);  // reject invalid notes before the long runs
  Table box{.number = "3.1",
            .name = "Table 3.1: polyhedra in a box, 1000 s simulated",
            .file = "table_3_1.csv",
            .figure = "3_8",
            .title = "Polyhedra in a box",
            .experiment = sleight::thesis::boxed_polyhedra(1000)};
  Table funnel{.number = "3.2",
               .name = "Table 3.2: grains through a funnel",
               .file = "table_3_2.csv",
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
    if (arguments.only.empty() || table->number == arguments.only) reproduce(*table, arguments);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Tables 3.1 and 3.2 of the thesis on stdout, figures 3.8 and 3.10 as SVG."};
  app.name("sleight-tables-3");
  Arguments arguments;
  app.add_option("--reference", arguments.reference,
                 "Folder of the thesis's tables, table_3_1.csv and table_3_2.csv")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "Folder of the figures")->capture_default_str();
  app.add_option("--seeds", arguments.seeds, "Simulations per row; 0: as the thesis, 5 and 10")
      ->capture_default_str();
  app.add_option("--only", arguments.only, "Table: 3.1 or 3.2; both if not given")
      ->check(CLI::IsMember({"3.1", "3.2"}));
  app.add_option("--note", arguments.notes, "NAME=VALUE for the pictures' metadata; repeatable")
      ->allow_extra_args(false);
  app.set_version_flag("--version", "sleight-tables-3 " + std::string(sleight::base::version()));
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
