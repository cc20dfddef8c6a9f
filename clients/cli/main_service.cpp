#include "clients/cli/main_service.h"

#include <fmt/format.h>

#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "clients/cli/fetch_command.h"
#include "clients/cli/job_commands.h"
#include "clients/cli/logs_command.h"
#include "clients/cli/main_run.h"
#include "clients/cli/main_settings.h"
#include "clients/cli/main_worlds.h"
#include "clients/cli/server_commands.h"
#include "clients/cli/submit_command.h"
#include "clients/service_client/fetched_archive.h"
#include "common/config/settings.h"
#include "common/request/direction_request.h"

namespace sleight::programs {
namespace {

using Action = std::function<int()>;

constexpr std::uint64_t k_number_max = 1'000'000'000'000;
constexpr std::int32_t k_priority_max = 1'000'000;
constexpr std::uint32_t k_ranks_max = 65536;
constexpr std::uint32_t k_lines_max = 100'000;

const char* const k_jobs_help = "17, a range 3..8, or a group g5; several may be given";
const char* const k_json_help = "As JSON";

/// A command whose options live as long as the app. `run` is its work.
template <class Options, class Run>
CLI::App* add_command(CLI::App& app, const char* name, const char* help, Action& action, Run run,
                      std::shared_ptr<Options> options) {
  CLI::App* command = app.add_subcommand(name, help);
  command->callback([&action, run, options] {
    action = [run, options] { return run(service_called(), *options); };
  });
  return command;
}

void add_jobs(CLI::App& command, cli::JobsOptions& options) {
  command.add_option("jobs", options.jobs, k_jobs_help)->required()->type_name("JOB");
  command.add_flag("--json", options.json, k_json_help);
}

/// The worlds of this program, for requests that are changed before they are sent.
cli::RequestTexts request_texts() {
  return {.normalised = [](std::string_view text, std::string_view file,
                           std::span<const request::KeySet> sets,
                           std::optional<request::Asked> asked)
              -> base::Result<std::string, std::vector<request::Diagnostic>> {
    const run::Catalogue catalogue = worlds_of_program();
    const auto read = request::read_request_with(text, file, catalogue.bindings(), sets, asked);
    if (!read) return read.error();
    return request::normalised_text(read.value());
  }};
}

void add_submit(CLI::App& app, Action& action) {
  const auto options = std::make_shared<cli::SubmitOptions>();
  const auto answer = std::make_shared<AnswerOptions>();
  CLI::App* command = add_command(
      app, "submit", "Hand a direction request to the service", action,
      [answer](const std::string& socket, cli::SubmitOptions given) {
        given.asked = answer->asked();
        given.asked_by = answer->words();
        return cli::submit(socket, given, request_texts());
      },
      options);
  CLI::Option* request = command
                             ->add_option("request", options->request_path,
                                          "The direction request, a TOML file; -: standard input")
                             ->type_name("REQUEST.toml");
  command->add_option("--word", options->word, "In place of a request: balls that spell this")
      ->excludes(request)
      ->type_name("WORD");
  add_answer_options(*command, *answer);
  command
      ->add_option(
          "--set", options->sets,
          "A key in place of the request's, as sampler.seed=7; a range (1..20) or a list ({1,4}) "
          "makes a group")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command->add_option("--cores", options->cores, "A wish; the cores that are free if not given")
      ->check(CLI::Range(std::uint32_t{1}, static_cast<std::uint32_t>(config::k_cores_max)))
      ->type_name("N");
  command->add_option("--ranks", options->ranks, "Run under mpirun with so many ranks")
      ->check(CLI::Range(1U, k_ranks_max))
      ->type_name("N");
  command
      ->add_option("--memory", options->memory,
                   "In which its processes together keep simulations (2GB); changes no result")
      ->type_name("SIZE");
  command->add_option("--priority", options->priority, "Among your jobs: higher ones first")
      ->check(CLI::Range(-k_priority_max, k_priority_max))
      ->type_name("N");
  command->add_option("--name", options->name, "For people; the file's or the word if not given")
      ->type_name("TEXT");
  command
      ->add_option("--option", options->options,
                   "For the system that runs it, as partition=long under Slurm; may be given "
                   "repeatedly")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command->add_flag("--strict", options->strict,
                    "End the run when a simulation fails, instead of refusing that state");
  command->add_flag("--watch", options->watch, "Show how it goes until it ends, as `watch` does");
  command->add_flag("--wait", options->wait, "Wait until it ends, as `wait` does");
  command->add_flag("--json", options->json, k_json_help);
  command->footer(
      "Prints the job's id. With --watch or --wait the exit code is that of `sleight wait`; "
      "Ctrl-C\n"
      "then leaves the job running. `sleight server start` starts the service.\n\n"
      "Examples:\n"
      "  sleight submit --word SLEIGHT\n"
      "  sleight submit requests/hi.toml --watch\n"
      "  sleight submit requests/ball_2d.toml --cores 4 --name throws --json | jq .id\n"
      "  sleight submit requests/hi.toml --set sampler.seed=1..20");
}

void add_list(CLI::App& app, Action& action) {
  const auto options = std::make_shared<cli::ListOptions>();
  CLI::App* command =
      add_command(app, "list", "The service's jobs", action, cli::list_jobs, options);
  command
      ->add_option("--state", options->states,
                   "Only those in this state; may be given repeatedly (queued, starting, running, "
                   "yielding, held, done, failed, cancelled)")
      ->allow_extra_args(false)
      ->type_name("STATE");
  command->add_flag("--mine", options->mine, "Only yours");
  command->add_option("--user", options->user, "Only this user's")->type_name("USER");
  command->add_option("--group", options->group, "Only this group's")->type_name("GROUP");
  command->add_option("--name", options->name, "Only those with this in their name")
      ->type_name("TEXT");
  command->add_option("--count", options->count, "Most that are shown")
      ->check(
          CLI::Range(std::uint32_t{1}, std::numeric_limits<std::uint32_t>::max()).description(""))
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--all", options->all, "All of them");
  command->add_flag("--oldest-first", options->oldest_first, "Not the newest first");
  command->add_option("--after", options->after, "Those after a page: `after` of its JSON")
      ->type_name("CURSOR");
  command->add_flag("--complete", options->complete, "Lines for shell completion")->group("");
  command->add_flag("--json", options->json, k_json_help);
  command->footer(
      "Solutions that a search found and those in the model's proportions are counted apart.\n\n"
      "Examples:\n"
      "  sleight list\n"
      "  sleight list --state running --state queued\n"
      "  sleight list --group g5 --json | jq '.jobs[].digest'");
}

void add_looks(CLI::App& app, Action& action) {
  const auto status = std::make_shared<cli::StatusOptions>();
  CLI::App* command =
      add_command(app, "status", "All about jobs", action, cli::show_status, status);
  add_jobs(*command, *status);
  command->add_flag("--history", status->history, "Each change of state, when and why");
  command->footer(
      "Examples:\n  sleight status 17\n  sleight status 17 --history\n"
      "  sleight status g5 --json | jq '.[].state'");

  const auto watched = std::make_shared<cli::WatchOptions>();
  command = add_command(app, "watch", "How jobs go, until they end", action, cli::watch, watched);
  add_jobs(*command, *watched);
  command->add_option("--from", watched->from_number, "Events from this number on")
      ->check(CLI::Range(std::uint64_t{1}, k_number_max).description(""))
      ->type_name("N");
  command->footer(
      "With --json a line an event: solutions, failures, ends of rounds and of sessions have\n"
      "numbers from 1 without a gap. Goes on when the service is restarted; Ctrl-C leaves the "
      "jobs\n"
      "running. Exits with 0 if all are done, 10 if one failed, 11 if one was cancelled.\n\n"
      "Examples:\n"
      "  sleight watch 17\n"
      "  sleight watch 17 --json --from 12\n"
      "  sleight watch g5");

  const auto awaited = std::make_shared<cli::JobsOptions>();
  command = add_command(app, "wait", "Wait until jobs end", action, cli::wait, awaited);
  add_jobs(*command, *awaited);
  command->footer(
      "Prints nothing but how they ended. Exits with 0 if all are done, 10 if one failed, 11 if "
      "one\nwas cancelled.\n\n"
      "Example:\n  sleight wait 17 && sleight fetch 17");

  const auto logs = std::make_shared<cli::LogsOptions>();
  command = add_command(app, "logs", "What a job's program wrote", action, cli::show_logs, logs);
  command->add_option("job", logs->job, "One job, 17")->required()->type_name("JOB");
  command->add_flag("-f,--follow", logs->follow, "Go on until the job ends");
  command->add_option("--lines", logs->lines, "The last so many")
      ->check(CLI::Range(1U, k_lines_max).description(""))
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--json", logs->json, k_json_help);
  command->footer("Examples:\n  sleight logs 17\n  sleight logs 17 -f --lines 10");
}

void add_stops(CLI::App& app, Action& action) {
  const auto add = [&](const char* name, const char* help, rpc::ChangeKind kind,
                       const char* footer) {
    const auto options = std::make_shared<cli::JobsOptions>();
    CLI::App* command = add_command(
        app, name, help, action,
        [kind](const std::string& socket, const cli::JobsOptions& given) {
          return cli::change(socket, given, {.kind = kind});
        },
        options);
    add_jobs(*command, *options);
    command->footer(footer);
  };
  add("cancel", "End jobs in order", rpc::ChangeKind::cancel,
      "A running job stops at a scan's end and keeps the archive of what it has.\n\n"
      "Examples:\n  sleight cancel 17\n  sleight cancel g5\n  sleight cancel 17 19 23..30");
  add("hold", "Stop jobs until `resume`", rpc::ChangeKind::hold,
      "Nothing is lost: `sleight resume` goes on to the same archive.\n\n"
      "Example:\n  sleight hold 17");
  add("resume", "Go on with held, failed or cancelled jobs", rpc::ChangeKind::resume,
      "Example:\n  sleight resume 17");
}

void add_priority(CLI::App& app, Action& action) {
  struct Options : cli::JobsOptions {
    std::int32_t priority = 0;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = add_command(
      app, "priority", "Which of your jobs come first", action,
      [](const std::string& socket, const Options& given) {
        return cli::change(socket, given,
                           {.kind = rpc::ChangeKind::set_priority, .priority = given.priority});
      },
      options);
  add_jobs(*command, *options);
  command->add_option("--to", options->priority, "Higher ones come first; 0 if never given")
      ->required()
      ->check(CLI::Range(-k_priority_max, k_priority_max))
      ->type_name("N");
  command->footer(
      "It orders the jobs of one user; between users, their shares of the machine do. A job that\n"
      "runs is not stopped for it.\n\n"
      "Examples:\n  sleight priority 17 --to 5\n  sleight priority g5 --to -1");
}

void add_extend(CLI::App& app, Action& action) {
  const auto options = std::make_shared<cli::ExtendOptions>();
  CLI::App* command = add_command(
      app, "extend", "Ask more of jobs", action,
      [](const std::string& socket, const cli::ExtendOptions& given) {
        return cli::change(
            socket, given,
            {.kind = rpc::ChangeKind::extend, .extension = cli::extension_of(given)});
      },
      options);
  add_jobs(*command, *options);
  CLI::App* rule = command->add_option_group("[stop]", "One rule, in place of the request's");
  rule->add_option("--scans", options->scans, "Scans of each chain")
      ->check(CLI::Range(std::uint64_t{1}, request::k_scans_max).description(""))
      ->type_name("N");
  rule->add_option("--rounds", options->rounds, "Rounds of tempering")
      ->check(CLI::Range(1U, request::k_rounds_max))
      ->type_name("N");
  rule->add_option("--solutions", options->solutions, "Independent solutions")
      ->check(CLI::Range(1U, request::k_independent_solutions_max))
      ->type_name("N");
  rule->add_option("--odds", options->odds, "Standard error of log P, in nats")
      ->check(CLI::Range(request::k_odds_min, request::k_odds_max))
      ->type_name("X");
  rule->require_option(1);
  command->footer(
      "The numbers are of the whole run, not added to it. The archive is the one that the longer\n"
      "request would have given at once.\n\n"
      "Examples:\n  sleight extend 17 --solutions 100\n  sleight extend g5 --scans 40000");
}

void add_fetch(CLI::App& app, Action& action) {
  const auto options = std::make_shared<cli::FetchOptions>();
  CLI::App* command = add_command(
      app, "fetch", "Bring jobs' archives here", action,
      [](const std::string& socket, const cli::FetchOptions& given) {
        return cli::fetch(socket, given, service_client::check_archive);
      },
      options);
  command->add_option("jobs", options->jobs, k_jobs_help)->required()->type_name("JOB");
  command
      ->add_option("-o,--output", options->output,
                   "job-17.h5 if not given; of several jobs a folder, g5 of a group")
      ->type_name("FILE");
  command->add_flag("--so-far", options->so_far, "Of what the run has by now");
  command
      ->add_option("--recordings", options->recordings,
                   "Kept animations by their ids (3,7,10..20), into a folder")
      ->type_name("IDS");
  command->add_flag("--failures", options->failures,
                    "Files for `sleight replay` of simulations that failed, into a folder");
  command->add_flag("--force", options->force, "Replace what is there");
  command->add_flag("-q,--quiet", options->quiet, "No progress, no names");
  command->add_flag("--json", options->json, k_json_help);
  command->footer(
      "A file is checked against its digest and put in place when it is whole; the same command\n"
      "goes on with a part that came. A file that is there with other content is left alone.\n\n"
      "Examples:\n"
      "  sleight fetch 17 -o hi.h5\n"
      "  sleight fetch 17 --so-far -o hi_so_far.h5\n"
      "  sleight fetch g5\n"
      "  sleight fetch 17 --failures && sleight replay job-17-failures/failure-0-3-1760.toml");
}

void add_keeps(CLI::App& app, Action& action) {
  const auto deleted = std::make_shared<cli::DeleteOptions>();
  CLI::App* command =
      add_command(app, "delete", "Delete jobs that have ended", action, cli::delete_jobs, deleted);
  add_jobs(*command, *deleted);
  command->add_flag("-y,--yes", deleted->yes, "Don't ask");
  command->footer(
      "With their archives and logs. Nothing is deleted where one of them has not ended, or is\n"
      "pinned. Asks on a terminal.\n\n"
      "Examples:\n  sleight delete 17\n  sleight delete g5 -y");

  struct PinOptions : cli::JobsOptions {
    bool off = false;
  };
  const auto pinned = std::make_shared<PinOptions>();
  command = add_command(
      app, "pin", "Keep jobs whatever the rule for finished jobs says", action,
      [](const std::string& socket, const PinOptions& given) {
        return cli::change(socket, given,
                           {.kind = given.off ? rpc::ChangeKind::unpin : rpc::ChangeKind::pin});
      },
      pinned);
  add_jobs(*command, *pinned);
  command->add_flag("--off", pinned->off, "The rule holds again");
  command->footer("Examples:\n  sleight pin 17\n  sleight pin 17 --off");
}

void add_server(CLI::App& app, Action& action) {
  CLI::App* server = app.add_subcommand("server", "The service of this machine");
  server->require_subcommand(1);
  const auto start = std::make_shared<cli::ServerStartOptions>();
  CLI::App* command = server->add_subcommand("start", "Start it in the background");
  add_setting_options(*command, start->given);
  command->add_flag("--foreground", start->foreground, "Here, until Ctrl-C");
  command->add_flag("--json", start->json, k_json_help);
  command->callback([&action, start] { action = [start] { return cli::start_server(*start); }; });
  command->footer(
      "Returns when it answers; its log is server.log in its state folder. Nothing needs "
      "configuring:\n`sleight config` shows the settings. One that runs already is left as it "
      "is.\n\n"
      "Examples:\n  sleight server start\n  sleight server start --cores 8 --memory 24GB");

  const auto add = [&](const char* name, const char* help, auto run, const char* footer) {
    const auto json = std::make_shared<bool>(false);
    CLI::App* one = server->add_subcommand(name, help);
    one->add_flag("--json", *json, k_json_help);
    one->callback(
        [&action, json, run] { action = [json, run] { return run(service_called(), *json); }; });
    one->footer(footer);
  };
  add("stop", "End it; jobs run on", cli::stop_server,
      "The next one takes the jobs over.\n\nExample:\n  sleight server stop");
  add("drain", "Start nothing more, and stop in order what runs", cli::drain_server,
      "Before the machine goes down, say. The next start goes on with the jobs.\n\n"
      "Example:\n  sleight server drain");
  add("status", "How it stands", cli::show_server,
      "Examples:\n  sleight server status\n  sleight server status --json | jq .pid");
}

}  // namespace

std::string service_called() {
  const config::ToCall call = config::service_to_call();
  return call.server.empty() ? call.socket : call.server;
}

void add_service_commands(CLI::App& app, std::function<int()>& action) {
  add_submit(app, action);
  add_list(app, action);
  add_looks(app, action);
  add_stops(app, action);
  add_priority(app, action);
  add_extend(app, action);
  add_fetch(app, action);
  add_keeps(app, action);
  add_server(app, action);
}

}  // namespace sleight::programs
