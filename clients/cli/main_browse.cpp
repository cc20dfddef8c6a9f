#include "clients/cli/main_browse.h"

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "clients/cli/main_service.h"
#include "clients/cli/number_in.h"
#include "common/request/text.h"

namespace sleight::programs {
namespace {

constexpr const char* k_query_words =
    "Queries:\n"
    "  die 3 in x 0..20mm y -5..5mm during 0.4..0.6s   its centre is in this box at some time in "
    "0.4..0.6s\n"
    "  any in z 30mm..                                 a body's centre is above 30 mm at some "
    "time\n"
    "  every ends in x -0.1..0.1                       every body comes to rest in the box\n"
    "  die 1 touches table during ..0.2s\n"
    "  die 1 touches table then die 1 touches die 2\n"
    "  log_prior -30..-20    rest_s < 2s    offsets[2] > 0\n"
    "  Precedence, highest first: then, not, and, or; use parentheses to group. Default units\n"
    "  are metres and seconds. Motion is solved exactly, not sampled at frames. To list the\n"
    "  names that queries can use, run `sleight find ARCHIVE.h5 --names`.\n\n";

void add_asked(CLI::App& command, browse::QueryOptions& asked) {
  command.add_option("--where", asked.where, "Keep animations that match this query. Repeatable")
      ->allow_extra_args(false)
      ->type_name("QUERY");
  command
      .add_option("--in", asked.in,
                  "Keep animations with a body in a box, such as 'die 3: x 0..20mm during "
                  "0.4..0.6s'. Repeatable")
      ->allow_extra_args(false)
      ->type_name("QUERY");
  command.add_option("--not", asked.not_in, "Remove animations that match this query. Repeatable")
      ->allow_extra_args(false)
      ->type_name("QUERY");
}

void add_archives(CLI::App& command, std::vector<std::string>& paths) {
  command.add_option("archives", paths, "Archives to read, from one or more runs")
      ->required()
      ->type_name("ARCHIVE.h5");
}

void add_find(CLI::App& app, cli::FindOptions& options, Action& action) {
  CLI::App* command = app.add_subcommand("find", "Find animations that match a query");
  add_archives(*command, options.paths);
  add_asked(*command, options.asked);
  command->add_option("--sort", options.sort, "Sort by this number (see --names)")
      ->type_name("NUMBER");
  command->add_flag("--descending", options.descending, "Sort the largest number first");
  command
      ->add_option("-n,--limit", options.limit,
                   "Maximum number of animations to print. Default: all")
      ->check(number_in(1, 1'000'000'000).description(""))
      ->type_name("N");
  command->add_flag("--names", options.names,
                    "List the names that queries can use: bodies, fixed things and numbers");
  command->add_flag("--ids", options.ids,
                    "Print only ids, one per line, as input for `sleight export --ids`");
  command->add_flag("--json", options.json, "Print JSON, with all numbers");
  command->footer(
      std::string(k_query_words) +
      "An animation must match all queries. Unreadable archives are reported and skipped.\n\n"
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
      app.add_subcommand("groups", "Group animations that look alike and show one of each group");
  add_archives(*command, options.paths);
  command->add_option("-k,--groups", options.groups, "Number of groups")
      ->check(number_in(1, 1'000'000).description(""))
      ->capture_default_str()
      ->type_name("K");
  command
      ->add_option("--by", options.by,
                   "medoids: best groups for this K; hierarchy: nested groups, where a smaller K "
                   "merges groups")
      ->check(CLI::IsMember({"medoids", "hierarchy"}))
      ->capture_default_str()
      ->type_name("WAY");
  add_asked(*command, options.asked);
  command
      ->add_option("-o,--output", options.output,
                   "Write an image that shows each group's representative")
      ->type_name("FILE.svg|FILE.png");
  command->add_flag("--json", options.json, "Print JSON, with all members");
  command->footer(
      "Animations look alike if their bodies are at the same places at the same times and\n"
      "collide in the same order; docs/BROWSING.md has the formula. If there are more than\n"
      "500 animations, the groups come from a sample: 200 animations, or 500 animations if more\n"
      "than 100 groups are requested. Each remaining animation joins the group with the nearest\n"
      "representative.\n\n"
      "Examples:\n  sleight groups hi.h5 -k 12\n"
      "  sleight groups die.h5 -k 6 -o die_groups.png\n"
      "  sleight groups a.h5 b.h5 --where 'log_prior -20..' --by hierarchy --json");
  command->callback([&] { action = [&] { return cli::group_animations(options); }; });
}

void add_compare(CLI::App& app, cli::CompareOptions& options, Action& action) {
  CLI::App* command = app.add_subcommand("compare", "Compare two archives");
  command->add_option("first", options.first, "First archive")->required()->type_name("FIRST.h5");
  command->add_option("second", options.second, "Second archive")
      ->required()
      ->type_name("SECOND.h5");
  command
      ->add_option("-k,--groups", options.groups,
                   "Number of groups. The animations of both archives are grouped together")
      ->check(number_in(1, 500).description(""))
      ->capture_default_str()
      ->type_name("K");
  command->add_flag("--json", options.json, "Print JSON");
  command->footer(
      "Shows where the two requests differ, and how numbers of animations such as log_prior\n"
      "differ. Counts the animations of each archive in each group. A test of nearest\n"
      "neighbours shows whether the two sets of animations look alike: a small p means that\n"
      "they look different.\n"
      "The animations in an archive are distinct, so they are not in the model's proportions; for\n"
      "means under the model, use the archive's group /posterior.\n\n"
      "Examples:\n  sleight compare die.h5 die_more_sigma.h5\n"
      "  sleight compare hi.h5 hi_tempered.h5 -k 12 --json");
  command->callback([&] { action = [&] { return cli::compare_archives(options); }; });
}

/// Adds the options that choose animations; add_export() adds the format's options.
void add_choice(CLI::App& command, cli::ExportChoice& choice) {
  command
      .add_option(
          "--ids", choice.ids,
          "Animation ids, such as c0.250 (chain 0, draw 250) or find.3 (found by a search). "
          "An id can begin with the run's id, as in RUN:c0.250")
      ->type_name("ID...");
  command
      .add_option("--select", choice.select,
                  "Animations that match this query (`sleight find --help`). Repeatable")
      ->allow_extra_args(false)
      ->type_name("QUERY");
  command
      .add_option("--representatives", choice.representatives,
                  "One representative for each of N groups of similar animations. The groups "
                  "contain the animations that match --select, or all animations")
      ->check(number_in(1, 1'000'000).description(""))
      ->type_name("N");
  command.add_flag(
      "--all", choice.all,
      fmt::format("Export all animations, even if there are more than {}", cli::k_export_max));
}

void add_export(CLI::App& app, cli::ExportAnimationsOptions& options, Action& action) {
  CLI::App* command =
      app.add_subcommand("export", "Export animations as 3D models, tables, images or videos");
  command->add_option("archive", options.path, "Archive to read")
      ->required()
      ->type_name("ARCHIVE.h5");
  command
      ->add_option("--format", options.format,
                   "glb: 3D model with motion (glTF 2.0, for Blender and others); csv: table; png: "
                   "folder of frames; svg: image of the whole motion; mp4: video (needs ffmpeg). "
                   "Default: the extension of OUT, otherwise glb")
      ->check(CLI::IsMember(cli::export_formats()))
      ->type_name("FORMAT");
  add_choice(*command, options.choice);
  command
      ->add_option("-o,--output", options.output,
                   "Output file with the format as its extension, such as ball.glb, or folder for "
                   "one file per animation. Default for csv: standard output")
      ->type_name("OUT");
  command->add_flag("--together", options.together,
                    "Write all animations as clips of one .glb file");
  command
      ->add_option("--fps", options.fps,
                   "Frames per second (png, mp4; default: 24). For glb: place keyframes on whole "
                   "frames only. Default for glb: enough keyframes to show positions within 0.1 mm "
                   "and rotations within 0.2 degrees")
      ->check(number_in(cli::k_export_fps_min, cli::k_export_fps_max).description(""))
      ->type_name("N");
  command->add_option("--view", options.view, "Camera view (png, mp4)")
      ->check(CLI::IsMember(cli::export_views()))
      ->capture_default_str()
      ->type_name("VIEW");
  command
      ->add_option("--scale", options.scale, "Image size (png, mp4), as a multiple of 1280 x 720")
      ->capture_default_str()
      ->type_name("FACTOR");
  command->add_option("--table", options.table, "Table to export (csv)")
      ->check(CLI::IsMember(cli::export_tables()))
      ->capture_default_str()
      ->type_name("TABLE");
  command->add_flag("--force", options.force, "Overwrite files that sleight did not make");
  command->add_flag("--json", options.json, "Print the list of written files as JSON");
  command->footer(
      "Examples:\n  sleight export ball.h5 --ids c0.250 -o ball.glb\n"
      "  sleight export die.h5 --select 'die 1 in z 60mm.. during 0.2s..' -o throws\n"
      "  sleight export die.h5 --representatives 12 --together -o kinds.glb\n"
      "  sleight export hi.h5 --ids find.0 -o hi.mp4\n"
      "  sleight export ball.h5 --format csv > animations.csv");
  command->callback([&] { action = [&] { return cli::export_animations(options); }; });
}

constexpr std::size_t k_shown_characters_max = 80;

/// Returns why a text isn't a valid HOST:PORT. HOST is an IPv6 address in brackets, or letters,
/// digits, dots and dashes. Empty if it is valid.
std::string fault_of_host(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon);
  const std::string port = colon == std::string::npos ? std::string() : text.substr(colon + 1);
  const bool is_ipv6 = host.size() > 2 && host.front() == '[' && host.back() == ']';
  const std::string_view allowed =
      is_ipv6 ? "0123456789abcdefABCDEF:."
              : "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-";
  const std::string name = is_ipv6 ? host.substr(1, host.size() - 2) : host;
  std::uint16_t number = 0;
  const auto [rest, failure] = std::from_chars(port.data(), port.data() + port.size(), number);
  const bool is_port = failure == std::errc() && rest == port.data() + port.size() && number != 0;
  if (is_port && !name.empty() && name.find_first_not_of(allowed) == std::string::npos) return {};
  return fmt::format("expected HOST:PORT, such as localhost:8080, found '{}'",
                     request::printable(text, k_shown_characters_max));
}

std::string fault_of_folder(const std::string& text) {
  return text.empty() ? "expected the name of a folder" : std::string();
}

}  // namespace

void add_browse_commands(CLI::App& app, BrowseArguments& arguments, Action& action) {
  add_find(app, arguments.find, action);
  add_groups(app, arguments.groups, action);
  add_compare(app, arguments.compare, action);
  add_export(app, arguments.exported, action);
}

void add_gallery_command(CLI::App& app, cli::CommandOptions& options, const analysis::Rules& rules,
                         Action& action) {
  CLI::App* command = app.add_subcommand(
      "gallery", "Show archives in the browser, with all animations, a player and plots");
  command
      ->add_option("archives", options.paths,
                   "Archives, folders of archives, or jobs of the service")
      ->required()
      ->type_name("ARCHIVE.h5|FOLDER|JOB");
  command
      ->add_option(
          "--port", options.port,
          fmt::format("TCP port to listen on. Default: {}, or any free port", cli::k_usual_port))
      ->check(number_in(1, 65535).description(""))
      ->type_name("PORT");
  command
      ->add_option(
          "--host", options.hosts,
          "Another address at which browsers reach the gallery, such as localhost:8080 if ssh -L "
          "forwards port 8080. 127.0.0.1:PORT and localhost:PORT always work. Repeatable")
      ->allow_extra_args(false)
      ->check(CLI::Validator(fault_of_host, ""))
      ->type_name("HOST:PORT");
  command->add_flag_callback(
      "--no-browser", [&options] { options.opens_browser = false; },
      "Print the link without opening a browser");
  command
      ->add_option("--save", options.save,
                   "Write the gallery as a folder of static files and exit. Publish the folder, or "
                   "double-click its index.html. Replaces an earlier saved gallery")
      ->check(CLI::Validator(fault_of_folder, ""))
      ->type_name("FOLDER");
  command->add_flag("--json", options.json, "Print link, port and process id as one line of JSON");
  command->footer(
      "The gallery listens on this machine's loopback address only. The gallery's link\n"
      "works in one browser only, so other users of the machine cannot open the gallery. From\n"
      "another machine, run `ssh -L PORT:127.0.0.1:PORT HOST` and open the same link.\n\n"
      "The page updates when an archive changes and when a running job commits new animations.\n"
      "Stars, tags and notes are stored in ~/.local/share/sleight/notes, or in the folder\n"
      "\"sleight-notes\" beside the archive if that folder exists; never in an archive.\n\n"
      "Examples:\n  sleight gallery hi.h5\n"
      "  sleight gallery results/ --no-browser --port 9000\n"
      "  sleight gallery 17\n"
      "  sleight gallery hi.h5 --save hi_gallery\n"
      "  ssh -L 8475:127.0.0.1:8475 cluster sleight gallery runs/hi.h5 --no-browser");
  command->callback(
      [&] { action = [&] { return cli::show_gallery(options, service_called, rules); }; });
}

}  // namespace sleight::programs
