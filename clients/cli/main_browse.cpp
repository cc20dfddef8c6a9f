#include "clients/cli/main_browse.h"

#include <fmt/format.h>

namespace sleight::programs {
namespace {

constexpr const char* k_query_words =
    "Queries:\n"
    "  die 3 in x 0..20mm y -5..5mm during 0.4..0.6s   its centre is in the box at some moment "
    "then\n"
    "  any in z 30mm..            some body's is, ever (`every`: each body's)\n"
    "  every ends in x -0.1..0.1  where each body rests\n"
    "  die 1 touches table during ..0.2s\n"
    "  die 1 touches table then die 1 touches die 2\n"
    "  log_prior -30..-20    rest_s < 2s    offsets[2] > 0\n"
    "  then, not, and, or bind in this order; ( ) too. `sleight find ARCHIVE.h5 --names` lists "
    "what they can speak "
    "of.\n"
    "  Paths are solved, not sampled. Lengths are metres and times seconds where no unit is "
    "said.\n\n";

void add_asked(CLI::App& command, browse::QueryOptions& asked) {
  command.add_option("--where", asked.where, "Only animations of which this query is true")
      ->allow_extra_args(false)
      ->type_name("QUERY");
  command.add_option("--in", asked.in, "The same, as in --in 'die 3: x 0..20mm during 0.4..0.6s'")
      ->allow_extra_args(false)
      ->type_name("QUERY");
  command.add_option("--not", asked.not_in, "Only animations of which this query is not true")
      ->allow_extra_args(false)
      ->type_name("QUERY");
}

void add_archives(CLI::App& command, std::vector<std::string>& paths) {
  command.add_option("archives", paths, "The archives, of one run or of several")
      ->required()
      ->type_name("ARCHIVE.h5");
}

void add_find(CLI::App& app, cli::FindOptions& options, Action& action) {
  CLI::App* command = app.add_subcommand("find", "The animations of archives that a query means");
  add_archives(*command, options.paths);
  add_asked(*command, options.asked);
  command->add_option("--sort", options.sort, "In the order of this number")->type_name("NUMBER");
  command->add_flag("--descending", options.descending, "The greatest first");
  command->add_option("-n,--limit", options.limit, "Most that are shown")
      ->check(CLI::Range(1, 1'000'000'000).description(""))
      ->type_name("N");
  command->add_flag("--names", options.names,
                    "What queries can speak of: bodies, things and numbers");
  command->add_flag("--ids", options.ids, "Their names alone, a line each, as export takes them");
  command->add_flag("--json", options.json, "As JSON, with all numbers");
  command->footer(std::string(k_query_words) +
                  "All options must hold. An archive that can't be read is left out, and said.\n\n"
                  "Examples:\n"
                  "  sleight find die.h5 --in 'die 1: x 0..40mm y -20..20mm during 0.2..0.4s'\n"
                  "  sleight find hi.h5 more/*.h5 --where 'any touches ball 1' --sort log_prior "
                  "--descending -n 10\n"
                  "  sleight find ball.h5 --where 'ball touches table then ball in x 0.. z 0.2..' "
                  "--not 'log_prior ..-12'\n"
                  "  sleight export die.h5 -o best --ids $(sleight find die.h5 --sort log_prior "
                  "--descending -n 3 --ids)\n"
                  "  sleight find die.h5 --names");
  command->callback([&] { action = [&] { return cli::find_animations(options); }; });
}

void add_groups(CLI::App& app, cli::GroupsOptions& options, Action& action) {
  CLI::App* command =
      app.add_subcommand("groups", "What looks alike, with an animation for each group");
  add_archives(*command, options.paths);
  command->add_option("-k,--groups", options.groups, "How many")
      ->check(CLI::Range(1, 1'000'000).description(""))
      ->capture_default_str()
      ->type_name("K");
  command->add_option("--by", options.by, "medoids: best for this K; hierarchy: nested for all K")
      ->check(CLI::IsMember({"medoids", "hierarchy"}))
      ->capture_default_str()
      ->type_name("WAY");
  add_asked(*command, options.asked);
  command->add_option("-o,--output", options.output, "A picture of those that stand for groups")
      ->type_name("FILE.svg|FILE.png");
  command->add_flag("--json", options.json, "As JSON, with all members");
  command->footer(
      "Alike are animations whose bodies are at the same places at equal times and meet in the "
      "same\n"
      "order; docs/BROWSING.md has the formula. Of more than 500 animations the groups are those "
      "of\n"
      "200 (of 500 for more than 100 groups), and each other one goes to the nearest.\n\n"
      "Examples:\n"
      "  sleight groups hi.h5 -k 12\n"
      "  sleight groups die.h5 -k 6 -o die_groups.png\n"
      "  sleight groups a.h5 b.h5 --where 'log_prior -20..' --by hierarchy --json");
  command->callback([&] { action = [&] { return cli::group_animations(options); }; });
}

void add_compare(CLI::App& app, cli::CompareOptions& options, Action& action) {
  CLI::App* command = app.add_subcommand("compare", "In what two archives differ");
  command->add_option("first", options.first, "An archive")->required()->type_name("FIRST.h5");
  command->add_option("second", options.second, "Another")->required()->type_name("SECOND.h5");
  command->add_option("-k,--groups", options.groups, "Into so many groups both together are put")
      ->check(CLI::Range(1, 500).description(""))
      ->capture_default_str()
      ->type_name("K");
  command->add_flag("--json", options.json, "As JSON");
  command->footer(
      "Their requests, the numbers of their animations, how many of each look alike, and a test "
      "by\n"
      "nearest neighbours: a small p says that the two sets look different. Kept animations are\n"
      "distinct ones, not the model's proportions: for means of the model see /posterior.\n\n"
      "Examples:\n"
      "  sleight compare die.h5 die_more_sigma.h5\n"
      "  sleight compare hi.h5 hi_tempered.h5 -k 12 --json");
  command->callback([&] { action = [&] { return cli::compare_archives(options); }; });
}

/// What is exported is chosen here; how it is written, in add_export.
void add_choice(CLI::App& command, cli::ExportChoice& choice) {
  command
      .add_option("--ids", choice.ids,
                  "These animations: cCHAIN.DRAW, or find.NUMBER of a search's finds; RUN: may "
                  "stand before")
      ->type_name("ID...");
  command
      .add_option("--select", choice.select,
                  "Those of which this query is true (`sleight find --help`)")
      ->allow_extra_args(false)
      ->type_name("QUERY");
  command
      .add_option("--representatives", choice.representatives,
                  "Of all, or those selected, one for each of N groups that look alike")
      ->check(CLI::Range(1, 1'000'000).description(""))
      ->type_name("N");
  command.add_flag("--all", choice.all,
                   fmt::format("All, also where there are more than {}", cli::k_export_max));
}

void add_export(CLI::App& app, cli::ExportAnimationsOptions& options, Action& action) {
  CLI::App* command = app.add_subcommand(
      "export", "Animations as models for Blender and others, as tables, pictures and films");
  command->add_option("archive", options.path, "The archive")->required()->type_name("ARCHIVE.h5");
  command
      ->add_option(
          "--format", options.format,
          "glb: glTF 2.0 with bodies, scene and motion; csv: a table; png: a folder of "
          "frames; svg: a picture of the whole motion; mp4: a film, by ffmpeg. Without, as "
          "OUT ends, or glb")
      ->check(CLI::IsMember(cli::export_formats()))
      ->type_name("FORMAT");
  add_choice(*command, options.choice);
  command
      ->add_option("-o,--output", options.output,
                   "A file that ends as the format does; else a folder for a file each")
      ->type_name("OUT");
  command->add_flag("--together", options.together, "All as clips of one .glb");
  command
      ->add_option("--fps", options.fps,
                   "Of png and mp4, frames a second (24). Of glb a key on each whole frame and "
                   "nowhere else; without, as many as keep places to 0.1 mm and turns to 0.2 "
                   "degrees")
      ->check(CLI::Range(cli::k_export_fps_min, cli::k_export_fps_max).description(""))
      ->type_name("N");
  command->add_option("--view", options.view, "Of png and mp4: both, above or front")
      ->check(CLI::IsMember(cli::export_views()))
      ->capture_default_str()
      ->type_name("VIEW");
  command->add_option("--scale", options.scale, "Of png and mp4: so many times 1280 x 720")
      ->capture_default_str()
      ->type_name("FACTOR");
  command->add_option("--table", options.table, "Of csv: animations, segments or points")
      ->check(CLI::IsMember(cli::export_tables()))
      ->capture_default_str()
      ->type_name("TABLE");
  command->add_flag("--force", options.force, "Replace files that sleight did not make");
  command->add_flag("--json", options.json, "What was written, as JSON");
  command->footer(
      "Examples:\n"
      "  sleight export ball.h5 --ids c0.250 -o ball.glb\n"
      "  sleight export die.h5 --select 'die 1 in z 60mm.. during 0.2s..' -o throws\n"
      "  sleight export die.h5 --representatives 12 --together -o kinds.glb\n"
      "  sleight export hi.h5 --ids find.0 -o hi.mp4\n"
      "  sleight export ball.h5 --format csv > animations.csv");
  command->callback([&] { action = [&] { return cli::export_animations(options); }; });
}

}  // namespace

void add_browse_commands(CLI::App& app, BrowseArguments& arguments, Action& action) {
  add_find(app, arguments.find, action);
  add_groups(app, arguments.groups, action);
  add_compare(app, arguments.compare, action);
  add_export(app, arguments.exported, action);
}

}  // namespace sleight::programs
