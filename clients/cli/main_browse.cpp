#include "clients/cli/main_browse.h"

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
    "  log_prior -30..-20    bounces = 3    offsets[2] > 0\n"
    "  and, or, not, ( ) join them. `sleight find ARCHIVE.h5 --names` lists what they can speak "
    "of.\n"
    "  Paths are solved, not sampled. Lengths are metres and times seconds where no unit is "
    "said.\n\n";

void add_asked(CLI::App& command, cli::QueryOptions& asked) {
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
  command->add_option("-n,--limit", options.limit, "At most so many")
      ->check(CLI::Range(1, 1'000'000'000).description(""))
      ->type_name("N");
  command->add_flag("--names", options.names,
                    "What queries can speak of: bodies, things and numbers");
  command->add_flag("--json", options.json, "As JSON, with all numbers");
  command->footer(std::string(k_query_words) +
                  "All options must hold. An archive that can't be read is left out, and said.\n\n"
                  "Examples:\n"
                  "  sleight find die.h5 --in 'die 1: x 0..40mm y -20..20mm during 0.2..0.4s'\n"
                  "  sleight find hi.h5 more/*.h5 --where 'any touches ball 1' --sort log_prior "
                  "--descending -n 10\n"
                  "  sleight find ball.h5 --where 'ball touches table then ball in x 0.. z 0.2..' "
                  "--not 'log_prior ..-12'\n"
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
      "500, and each other one goes to the nearest.\n\n"
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

}  // namespace

void add_browse_commands(CLI::App& app, BrowseArguments& arguments, Action& action) {
  add_find(app, arguments.find, action);
  add_groups(app, arguments.groups, action);
  add_compare(app, arguments.compare, action);
}

}  // namespace sleight::programs
