// The command line of `sleight`: what each local command takes and which function it hands over to.
#include "clients/cli/main_app.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "clients/cli/archive_commands.h"
#include "clients/cli/diagnose_command.h"
#include "clients/cli/main_browse.h"
#include "clients/cli/main_derive.h"
#include "clients/cli/main_direct.h"
#include "clients/cli/main_gallery.h"
#include "clients/cli/main_own.h"
#include "clients/cli/main_run.h"
#include "clients/cli/main_service.h"
#include "clients/cli/main_token.h"
#include "clients/cli/main_world_plots.h"
#include "clients/cli/plot_command.h"
#include "common/archive/csv.h"
#include "worker/sampling/diagnostics/convergence.h"

namespace sleight::programs {
namespace {

/// Largest chain or number of draws that can be asked for.
constexpr std::uint64_t k_number_max = 1'000'000'000'000;

void add_direct(CLI::App& app, DirectArguments& arguments, Action& action) {
  CLI::App* command = app.add_subcommand("direct", "Run a direction request on this machine");
  add_run_options(*command, arguments);
  command->add_option("-j,--threads", arguments.threads, "Threads; one a core if not given")
      ->check(CLI::Range(1, 4096))
      ->type_name("N");
  command->footer(
      "The run goes on where it stopped when the same command is given again, after Ctrl-C, a\n"
      "time limit, kill -9 or loss of power. Neither threads nor interruptions change the "
      "archive.\n\n"
      "Examples:\n"
      "  sleight direct --word SLEIGHT -o s.h5\n"
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
  CLI::App* check = app.add_subcommand("check", "Check a request; print it with every key");
  check->add_option("request", arguments.path, "The direction request; -: standard input")
      ->required()
      ->type_name("REQUEST.toml");
  add_sets_option(*check, arguments.sets);
  check->footer(
      "Examples:\n"
      "  sleight check requests/ball_2d.toml\n"
      "  sleight check requests/ball_2d.toml --set sampler.chains=8 --set stop.scans=1000");
  check->callback([&] { action = [&] { return check_request(arguments.path, arguments.sets); }; });

  CLI::App* keys = app.add_subcommand("keys", "List the worlds, or every request key of one");
  keys->add_option("world", arguments.world, "The world's name")->type_name("WORLD");
  keys->footer("Examples:\n  sleight keys\n  sleight keys ball_2d\n  sleight keys spelling");
  keys->callback([&] { action = [&] { return print_keys(arguments.world); }; });
}

/// How `sleight diagnose` judges a scalar.
analysis::Verdict judge(std::string_view name, const analysis::ScalarDraws& draws) {
  // Where thin is longer than the judged scans, no state is archived of them.
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
  command->add_option("file", arguments.path, "Of OUTPUT.h5.run/failures")
      ->required()
      ->type_name("FAILURE.toml");
  command->add_flag("--json", arguments.json, "As JSON");
  command->footer(
      "Exits with 8 if the simulation fails as it did, or otherwise, and with 0 if this version\n"
      "carries it out. A file that was changed, or is none of a failure, exits with 3.\n\n"
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
      archive.add_subcommand("derive", "The archive of a run so far, out of its store");
  command->add_option("run", arguments.folder, "The run's folder")
      ->required()
      ->type_name("NAME.h5.run");
  command->add_option("-o,--output", arguments.output, "The archive")
      ->required()
      ->type_name("OUTPUT.h5");
  command->add_flag("--json", arguments.json, "What it holds, as JSON");
  command->footer(
      "Works beside the running job, and on a copy of its folder that was made while nobody wrote\n"
      "it. The archive is the one that the run would have if it ended now.\n\nExample:\n"
      "  sleight archive derive ball.h5.run -o ball_so_far.h5");
  command->callback([&] { action = [&] { return derive(arguments); }; });
}

CLI::App* add_archive(CLI::App& app, ArchiveArguments& arguments, Action& action) {
  CLI::App* archive = app.add_subcommand("archive", "Look into a sample archive");
  archive->require_subcommand(1);
  std::string& path = arguments.export_options.path;
  const auto add = [&](const char* name, const char* help, bool with_json,
                       std::function<int()> run) {
    CLI::App* command = archive->add_subcommand(name, help);
    command->add_option("archive", path, "The archive")->required()->type_name("ARCHIVE.h5");
    if (with_json) command->add_flag("--json", arguments.json, "As JSON");
    command->callback([&action, run = std::move(run)] { action = run; });
    return command;
  };
  add("info", "What it holds", true, [&] {
    return cli::archive_info(path, arguments.json);
  })->footer("Examples:\n  sleight archive info ball.h5\n  sleight archive info ball.h5 --json");
  add("digest", "Hash of its content: equal for equal content", true, [&] {
    return cli::archive_digest(path, arguments.json);
  })->footer("Example:\n  sleight archive digest ball.h5");
  add("verify", "Check structure, invariants and digest", true,
      [&] { return cli::archive_verify(path, arguments.json); })
      ->footer(
          "Exits with 6 and prints every finding when something is wrong.\n\nExample:\n"
          "  sleight archive verify ball.h5");
  CLI::App* exported = add("export", "A table as CSV", false,
                           [&] { return cli::archive_export_csv(arguments.export_options); });
  exported->add_flag("--csv", arguments.csv, "Comma-separated values, the only format yet")
      ->required();
  exported
      ->add_option("--table", arguments.export_options.table,
                   fmt::format("{}", fmt::join(archive::csv_tables(), ", ")))
      ->check(CLI::IsMember(archive::csv_tables()))
      ->capture_default_str()
      ->type_name("TABLE");
  exported
      ->add_option("--animation", arguments.export_options.animations,
                   "Of a table of segments only this animation; may be given repeatedly")
      ->allow_extra_args(false)
      ->type_name("N");
  exported->add_option("-o,--output", arguments.export_options.output, "stdout if not given")
      ->type_name("FILE.csv");
  exported->footer(
      "Examples:\n"
      "  sleight archive export ball.h5 --csv > stats.csv\n"
      "  sleight archive export ball.h5 --csv --table posterior -o normals.csv");
  return archive;
}

struct DiagnoseArguments {
  std::string path;
  bool json = false;
};

void add_diagnose(CLI::App& app, DiagnoseArguments& arguments, Action& action) {
  CLI::App* command = app.add_subcommand("diagnose", "Whether an archive's chains have mixed");
  command->add_option("archive", arguments.path, "The archive")
      ->required()
      ->type_name("ARCHIVE.h5");
  command->add_flag("--json", arguments.json, "As JSON");
  command->footer(
      "Judges log p, the outcomes and the state by R-hat (at most 1.01) and effective sample size\n"
      "(at least 400, and 100 for each chain): the longest round of a tempered run, or the second\n"
      "half of plain chains. Ladders must have made a round trip. Exits with 7 and says why when\n"
      "the chains have not mixed. No complaint is no proof: chains that all miss a mode agree.\n\n"
      "Examples:\n"
      "  sleight diagnose ball.h5\n"
      "  sleight diagnose ball.h5 --json | jq .reasons");
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
  CLI::App* command = app.add_subcommand("plot", "Draw an archive: on the terminal, SVG or PNG");
  command->add_option("archive", options.path, "The archive")->required()->type_name("ARCHIVE.h5");
  command->add_option("-o,--output", options.output, "A picture; the terminal if not given")
      ->type_name("FILE.svg|FILE.png");
  command->add_option("--what", options.what, cli::help_of_whats(arguments.worlds))
      ->check(CLI::IsMember(cli::whats_of(arguments.worlds)));
  command->add_option("--chain", options.chain, "Only this chain")
      ->check(CLI::Range(std::uint64_t{0}, k_number_max).description(""))
      ->type_name("N");
  command->add_option("--draws", options.draws, "Only the first so many draws")
      ->check(CLI::Range(std::uint64_t{1}, k_number_max).description(""))
      ->type_name("N");
  command->add_option("--count", options.count, "Paths or animations to draw")
      ->check(CLI::Range(1, 12))
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--note", options.notes, "A line for an SVG's metadata; may be given repeatedly")
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE");
  command->footer(
      "Examples:\n"
      "  sleight plot ball.h5\n"
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
  app.description(
      "Sleight directs physical simulations: say how a chaotic motion must end, get many "
      "different\n"
      "plausible animations that end so.");
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.footer(std::string("`sleight COMMAND --help` has examples.\n\n") + k_exit_codes);
  app.add_flag("-v,--verbose", line.verbose, "More on stderr");

  // Runs and archives on this machine.
  CommandLine::Arguments& arguments = *line.arguments_;
  Action& action = line.action;
  add_direct(app, arguments.direct, action);
  add_request_help(app, arguments.request_help, action);
  add_replay(app, arguments.replay, action);
  add_derive(*add_archive(app, arguments.archive, action), arguments.derive, action);
  add_diagnose(app, arguments.diagnose, action);
  add_plot(app, arguments.plot, action);
  add_browse_commands(app, arguments.browse, action);
  add_gallery_command(app, arguments.gallery, arguments.rules, action);
  add_service_commands(app, action);
  add_token_commands(app, action);

  // The program itself.
  add_own_commands(app, arguments.own, action);
}

}  // namespace sleight::programs
