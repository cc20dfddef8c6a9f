// The command line of `sleight`: each local command's options, and the function that runs the
// command.
#include "clients/cli/main_app.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "clients/cli/archive_commands.h"
#include "clients/cli/main_browse.h"
#include "clients/cli/main_derive.h"
#include "clients/cli/main_direct.h"
#include "clients/cli/main_own.h"
#include "clients/cli/main_run.h"
#include "clients/cli/main_scene.h"
#include "clients/cli/main_service.h"
#include "clients/cli/main_token.h"
#include "clients/cli/main_world_plots.h"
#include "clients/cli/number_in.h"
#include "clients/cli/plot_command.h"
#include "common/archive/csv.h"
#include "worker/sampling/diagnostics/convergence.h"

namespace sleight::programs {
namespace {

/// Maximum value of options for a chain's number or a number of draws.
constexpr std::uint64_t k_number_max = 1'000'000'000'000;

void add_direct(CLI::App& app, DirectArguments& arguments, Action& action) {
  CLI::App* command = app.add_subcommand("direct", "Run a direction request on this machine");
  add_run_options(*command, arguments);
  command->add_option("-j,--threads", arguments.threads, "Number of threads. Default: one per core")
      ->check(number_in(1, 4096))
      ->type_name("N");
  command->footer(
      "To resume a run after Ctrl-C, a time limit, kill -9 or a power failure, repeat the "
      "command.\n"
      "The archive does not depend on the number of threads or on interruptions.\n\n"
      "Examples:\n  sleight direct --word SLEIGHT -o s.h5\n"
      "  sleight direct --word HI -n 8 --found -o hi.h5\n"
      "  sleight direct --word HI --in-proportion -o hi.h5 --print-request\n"
      "  sleight direct requests/ball_2d.toml -o ball.h5\n"
      "  sleight direct requests/ball_2d.toml -o ball.h5 --time-limit 20s\n"
      "  sleight direct requests/hi.toml -o hi.h5 --seed 7 --json\n"
      "  sleight direct requests/hi.toml -o hi.h5 --set world.word=HELLO --set sampler.chains=2");
  command->callback([&] { action = [&] { return direct(arguments); }; });
}

struct RequestHelpArguments {
  std::string path;
  std::vector<std::string> sets;
  std::string world;
};

void add_request_help(CLI::App& app, RequestHelpArguments& arguments, Action& action) {
  CLI::App* check = app.add_subcommand("check", "Check a request and print it with all keys");
  check->add_option("request", arguments.path, "Direction request (TOML). -: standard input")
      ->required()
      ->type_name("REQUEST.toml");
  add_sets_option(*check, arguments.sets);
  check->footer(
      "Examples:\n  sleight check requests/ball_2d.toml\n"
      "  sleight check requests/ball_2d.toml --set sampler.chains=8 --set stop.scans=1000");
  check->callback([&] { action = [&] { return check_request(arguments.path, arguments.sets); }; });

  CLI::App* keys = app.add_subcommand("keys", "List the worlds, or all request keys of one world");
  keys->add_option("world", arguments.world, "Name of a world. Default: list the worlds")
      ->type_name("WORLD");
  keys->footer("Examples:\n  sleight keys\n  sleight keys ball_2d\n  sleight keys spelling");
  keys->callback([&] { action = [&] { return print_keys(arguments.world); }; });
}

analysis::Verdict judge(std::string_view name, const analysis::ScalarDraws& draws) {
  // If `thin` exceeds the number of judged scans, the archive may have no state of these scans.
  if (draws.draws == 0) return {};
  const sampling::Convergence found = sampling::convergence_of(
      {.values = draws.values, .chains = draws.chains, .draws = draws.draws});
  return {.mean = found.mean,
          .sd = found.sd,
          .mcse = found.mcse_mean,
          .r_hat = found.r_hat,
          .ess_bulk = found.ess_bulk,
          .ess_tail = found.ess_tail,
          .constant = found.constant,
          .complaints = sampling::complaints(name, found)};
}

analysis::Rules convergence_rules() {
  return {.draws_min = sampling::k_draws_per_chain_min,
          .ess_wanted = sampling::ess_wanted,
          .judge = judge};
}

struct ReplayArguments {
  std::string path;
  bool json = false;
};

void add_replay(CLI::App& app, ReplayArguments& arguments, Action& action) {
  CLI::App* command = app.add_subcommand("replay", "Repeat a simulation that failed in a run");
  command->add_option("file", arguments.path, "Failure file, from OUTPUT.h5.run/failures")
      ->required()
      ->type_name("FAILURE.toml");
  command->add_flag("--json", arguments.json, "Print JSON");
  command->footer(
      "Exit codes: 0 the simulation succeeds in this version; 8 the simulation fails, in the\n"
      "same way or in another; 3 the file is not a valid failure file.\n\n"
      "Example:\n  sleight replay hi.h5.run/failures/failure-0-3-1760.toml");
  command->callback([&] { action = [&] { return replay(arguments.path, arguments.json); }; });
}

struct ArchiveArguments {
  cli::ExportOptions export_options;
  bool json = false;
  bool csv = false;
};

void add_derive(CLI::App& archive, DeriveArguments& arguments, Action& action) {
  CLI::App* command =
      archive.add_subcommand("derive", "Write an archive of what a run has computed so far");
  command->add_option("run", arguments.folder, "Folder of the run")
      ->required()
      ->type_name("NAME.h5.run");
  command->add_option("-o,--output", arguments.output, "Archive to write")
      ->required()
      ->type_name("OUTPUT.h5");
  command->add_flag("--json", arguments.json, "Print a summary of the archive as JSON");
  command->footer(
      "Writes the archive that the run would write if it stopped now. The run can continue\n"
      "meanwhile. A copy of the run's folder works too, unless the run wrote to the folder during\n"
      "the copy.\n\n"
      "Example:\n  sleight archive derive ball.h5.run -o ball_so_far.h5");
  command->callback([&] { action = [&] { return derive(arguments); }; });
}

CLI::App* add_archive(CLI::App& app, ArchiveArguments& arguments, Action& action) {
  CLI::App* archive =
      app.add_subcommand("archive", "Inspect a sample archive or export its tables");
  archive->require_subcommand(1);
  std::string& path = arguments.export_options.path;
  const auto add = [&](const char* name, const char* help, bool with_json,
                       std::function<int()> run) {
    CLI::App* command = archive->add_subcommand(name, help);
    command->add_option("archive", path, "Archive to read")->required()->type_name("ARCHIVE.h5");
    if (with_json) command->add_flag("--json", arguments.json, "Print JSON");
    command->callback([&action, run = std::move(run)] { action = run; });
    return command;
  };
  add("info", "Print a summary of an archive", true, [&] {
    return cli::archive_info(path, arguments.json);
  })->footer("Examples:\n  sleight archive info ball.h5\n  sleight archive info ball.h5 --json");
  add("digest", "Print the digest (SHA-256) of an archive's content", true, [&] {
    return cli::archive_digest(path, arguments.json);
  })->footer("Example:\n  sleight archive digest ball.h5");
  add("verify", "Check an archive's structure, invariants and digest", true,
      [&] { return cli::archive_verify(path, arguments.json); })
      ->footer(
          "Prints every error. Exits with 6 if there are errors.\n\n"
          "Example:\n  sleight archive verify ball.h5");
  CLI::App* exported = add("export", "Export a table as CSV", false,
                           [&] { return cli::archive_export_csv(arguments.export_options); });
  exported->add_flag("--csv", arguments.csv, "Write comma-separated values, the only format so far")
      ->required();
  exported->add_option("--table", arguments.export_options.table, "Table to export")
      ->check(CLI::IsMember(archive::csv_tables()))
      ->capture_default_str()
      ->type_name("TABLE");
  exported
      ->add_option(
          "--animation", arguments.export_options.animations,
          "Export only the rows of this animation (tables animations, segments and points). "
          "Repeatable")
      ->allow_extra_args(false)
      ->type_name("N");
  exported
      ->add_option("-o,--output", arguments.export_options.output,
                   "CSV file to write. Default: standard output")
      ->type_name("FILE.csv");
  exported->footer(
      "Examples:\n  sleight archive export ball.h5 --csv > stats.csv\n"
      "  sleight archive export ball.h5 --csv --table posterior -o normals.csv");
  return archive;
}

struct DiagnoseArguments {
  std::string path;
  bool json = false;
};

void add_diagnose(CLI::App& app, DiagnoseArguments& arguments, Action& action) {
  CLI::App* command =
      app.add_subcommand("diagnose", "Check whether an archive's chains have mixed");
  command->add_option("archive", arguments.path, "Archive to read")
      ->required()
      ->type_name("ARCHIVE.h5");
  command->add_flag("--json", arguments.json, "Print JSON");
  command->footer(
      "Checks R-hat and the effective sample size of log p, the outcomes and the state. R-hat\n"
      "must be at most 1.01. The effective sample size must be at least 400, and at least 100 per\n"
      "chain. Judges the longest round of a tempered run, or the second half of each plain chain.\n"
      "A tempered ladder must also have made a round trip. If the chains have not mixed, prints\n"
      "the reasons and exits with 7. Success is no proof that the chains have mixed: chains that\n"
      "all miss the same mode agree with each other.\n\n"
      "Examples:\n  sleight diagnose ball.h5\n  sleight diagnose ball.h5 --json | jq .reasons");
  command->callback([&] {
    action = [&] {
      return cli::diagnose_archive(arguments.path, arguments.json, convergence_rules());
    };
  });
}

struct PlotArguments {
  cli::PlotOptions options;
  pictures::PlotsOfWorlds worlds = plots_of_program();
};

void add_plot(CLI::App& app, PlotArguments& arguments, Action& action) {
  cli::PlotOptions& options = arguments.options;
  CLI::App* command =
      app.add_subcommand("plot", "Plot an archive on the terminal or into an SVG or PNG file");
  command->add_option("archive", options.path, "Archive to read")
      ->required()
      ->type_name("ARCHIVE.h5");
  command
      ->add_option("-o,--output", options.output, "Image to write. Default: plot on the terminal")
      ->type_name("FILE.svg|FILE.png");
  command->add_option("--what", options.what, cli::help_of_whats(arguments.worlds))
      ->check(CLI::IsMember(cli::whats_of(arguments.worlds)));
  command->add_option("--chain", options.chain, "Plot only this chain. Default: all")
      ->check(number_in(std::uint64_t{0}, k_number_max).description(""))
      ->type_name("N");
  command->add_option("--draws", options.draws, "Plot only the first N draws. Default: all")
      ->check(number_in(std::uint64_t{1}, k_number_max).description(""))
      ->type_name("N");
  command->add_option("--count", options.count, "Number of paths or animations to plot")
      ->check(number_in(1, 12))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--note", options.notes, "Metadata to add to an SVG. Repeatable")
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE");
  command->footer(
      "Examples:\n  sleight plot ball.h5\n"
      "  sleight plot ball.h5 --chain 0 --draws 1000 -o figure_2_4.svg\n"
      "  sleight plot ball.h5 --what paths -o figure_2_3.png\n"
      "  sleight plot hi.h5 --chain 0 -o hi_filled.svg\n"
      "  sleight plot hi.h5 --what animations --count 4 -o hi_animations.png\n"
      "  sleight plot die.h5 --what animations -o die_animations.svg\n"
      "  sleight plot die.h5 --what plausibility -o die_plausibility.svg");
  command->callback(
      [&] { action = [&] { return cli::plot_archive(arguments.options, arguments.worlds); }; });
}

}  // namespace

struct CommandLine::Arguments {
  DirectArguments direct;
  RequestHelpArguments request_help;
  SceneArguments scene;
  ReplayArguments replay;
  ArchiveArguments archive;
  DeriveArguments derive;
  DiagnoseArguments diagnose;
  BrowseArguments browse;
  cli::CommandOptions gallery;
  analysis::Rules rules = convergence_rules();
  PlotArguments plot;
  OwnArguments own;
};

CommandLine::CommandLine() : arguments_(std::make_unique<Arguments>()) {}
CommandLine::~CommandLine() = default;

void build_app(CLI::App& app, CommandLine& line) {
  app.name("sleight");
  app.failure_message(usage_words);
  app.description(
      "Sleight directs physical simulations: you specify how a chaotic motion must end, and get\n"
      "many different, plausible animations that end that way.");
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.footer(std::string("`sleight COMMAND --help` shows a command's options and examples.\n\n") +
             k_exit_codes);
  app.add_flag("-v,--verbose", line.verbose, "Log more to stderr");

  CommandLine::Arguments& arguments = *line.arguments_;
  Action& action = line.action;
  add_direct(app, arguments.direct, action);
  add_request_help(app, arguments.request_help, action);
  add_scene_commands(app, arguments.scene, action);
  add_replay(app, arguments.replay, action);
  add_derive(*add_archive(app, arguments.archive, action), arguments.derive, action);
  add_diagnose(app, arguments.diagnose, action);
  add_plot(app, arguments.plot, action);
  add_browse_commands(app, arguments.browse, action);
  add_gallery_command(app, arguments.gallery, arguments.rules, action);
  add_service_commands(app, action);
  add_token_commands(app, action);

  add_own_commands(app, arguments.own, action);
}

}  // namespace sleight::programs
