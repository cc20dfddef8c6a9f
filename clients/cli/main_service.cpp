#include "clients/cli/main_service.h"

#include <limits>
#include <memory>
#include <string>

#include "clients/cli/fetch_command.h"
#include "clients/cli/job_commands.h"
#include "clients/cli/logs_command.h"
#include "clients/cli/main_run.h"
#include "clients/cli/main_settings.h"
#include "clients/cli/main_worlds.h"
#include "clients/cli/number_in.h"
#include "clients/cli/server_commands.h"
#include "clients/cli/submit_command.h"
#include "common/config/settings.h"
#include "common/request/direction_request.h"

namespace sleight::programs {
namespace {

using Action = std::function<int()>;

constexpr std::uint64_t k_number_max = 1'000'000'000'000;
constexpr std::int32_t k_priority_max = 1'000'000;
constexpr std::uint32_t k_ranks_max = 65536;
constexpr std::uint32_t k_lines_max = 100'000;

const char* const k_jobs_help = "Job number (17), range (3..8) or group (g5)";
const char* const k_json_help = "Print JSON";

/// Adds a command whose options live as long as the app. `run` executes it.
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

/// Returns functions that use this program's worlds to change a request before it is sent.
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
      app, "submit", "Submit a direction request to the service", action,
      [answer](const std::string& socket, cli::SubmitOptions given) {
        given.asked = answer->asked();
        given.asked_by = answer->words();
        return cli::submit(socket, given, request_texts());
      },
      options);
  CLI::Option* request = command
                             ->add_option("request", options->request_path,
                                          "Direction request (TOML). -: standard input")
                             ->type_name("REQUEST.toml");
  command
      ->add_option("--word", options->word,
                   "Spell this word with balls, instead of reading a request")
      ->excludes(request)
      ->type_name("WORD");
  add_answer_options(*command, *answer);
  command
      ->add_option(
          "--set", options->sets,
          "Override a key of the request, for example sampler.seed=7. A range (1..20) or a "
          "list ({1,4}) submits a group of jobs. Repeatable")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command
      ->add_option(
          "--cores", options->cores,
          "Maximum number of cores. Default: the service's job_cores, usually all free cores")
      ->check(number_in(std::uint32_t{1}, static_cast<std::uint32_t>(config::k_cores_max)))
      ->type_name("N");
  command->add_option("--ranks", options->ranks, "Run under mpirun with this number of ranks")
      ->check(number_in(1U, k_ranks_max))
      ->type_name("N");
  command
      ->add_option("--memory", options->memory,
                   "Total simulation cache of all processes, for example 2GB. Affects speed, "
                   "not results. Default: the service's cache_mb per process")
      ->type_name("SIZE");
  command
      ->add_option(
          "--priority", options->priority,
          "Priority among your own jobs; jobs with a higher priority run first. Default: 0")
      ->check(number_in(-k_priority_max, k_priority_max))
      ->type_name("N");
  command
      ->add_option("--name", options->name,
                   "Name of the job. Default: the request's file name, or the word")
      ->type_name("TEXT");
  command
      ->add_option("--option", options->options,
                   "Option for the system that runs the job, for example partition=long for Slurm. "
                   "Repeatable")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command->add_flag(
      "--strict", options->strict,
      "Stop the run if a simulation fails. Default: reject the proposal and continue");
  command->add_flag("--watch", options->watch,
                    "Show progress until the job ends, as `sleight watch` does");
  command->add_flag("--wait", options->wait, "Wait until the job ends, as `sleight wait` does");
  command->add_flag("--json", options->json, k_json_help);
  command->footer(
      "Prints the job's id. With --watch or --wait, Ctrl-C leaves the job running, and the\n"
      "exit codes are the same as for `sleight wait`. To start the service, run\n"
      "`sleight server start`.\n\n"
      "Examples:\n  sleight submit --word SLEIGHT\n"
      "  sleight submit requests/hi.toml --watch\n"
      "  sleight submit requests/ball_2d.toml --cores 4 --name throws --json | jq .id\n"
      "  sleight submit requests/hi.toml --set sampler.seed=1..20");
}

void add_list(CLI::App& app, Action& action) {
  const auto options = std::make_shared<cli::ListOptions>();
  CLI::App* command = add_command(app, "list", "List jobs", action, cli::list_jobs, options);
  command
      ->add_option("--state", options->states,
                   "List only jobs in this state: queued, starting, running, yielding, held, done, "
                   "failed or cancelled. Repeatable")
      ->allow_extra_args(false)
      ->type_name("STATE");
  command->add_flag("--mine", options->mine, "List only your jobs");
  command->add_option("--user", options->user, "List only jobs of this user")->type_name("USER");
  command->add_option("--group", options->group, "List only jobs of this group (g5)")
      ->type_name("GROUP");
  command->add_option("--name", options->name, "List only jobs whose name contains this text")
      ->type_name("TEXT");
  command->add_option("--count", options->count, "Maximum number of jobs to list")
      ->check(
          number_in(std::uint32_t{1}, std::numeric_limits<std::uint32_t>::max()).description(""))
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--all", options->all, "List all jobs, however many");
  command->add_flag("--oldest-first", options->oldest_first,
                    "List the oldest job first. Default: the newest");
  command
      ->add_option("--after", options->after,
                   "Continue a list; CURSOR is the value of `after` in the previous page's JSON")
      ->type_name("CURSOR");
  command->add_flag("--complete", options->complete, "Print lines for shell completion")->group("");
  command->add_flag("--json", options->json, k_json_help);
  command->footer(
      "The column FOUND counts solutions of a search. The column IN PROPORTION counts solutions\n"
      "drawn in the model's proportions.\n\n"
      "Examples:\n  sleight list\n  sleight list --state running --state queued\n"
      "  sleight list --group g5 --json | jq '.jobs[].digest'");
}

void add_looks(CLI::App& app, Action& action) {
  const auto status = std::make_shared<cli::StatusOptions>();
  CLI::App* command =
      add_command(app, "status", "Show jobs in detail", action, cli::show_status, status);
  add_jobs(*command, *status);
  command->add_flag("--history", status->history,
                    "Show each change of state, with time and reason");
  command->footer(
      "Examples:\n  sleight status 17\n  sleight status 17 --history\n"
      "  sleight status g5 --json | jq '.[].state'");

  const auto watched = std::make_shared<cli::WatchOptions>();
  command = add_command(app, "watch", "Show the progress of jobs until they end", action,
                        cli::watch, watched);
  add_jobs(*command, *watched);
  command
      ->add_option("--from", watched->from_number, "Number of the first event to show. Default: 1")
      ->check(number_in(std::uint64_t{1}, k_number_max).description(""))
      ->type_name("N");
  command->footer(
      "With --json, prints one line per event. Solutions, failures, ends of rounds and ends\n"
      "of sessions are numbered from 1 without gaps. A restart of the service doesn't end the\n"
      "command. Ctrl-C leaves the jobs running.\n\n"
      "Exit codes: 0 all jobs are done; 10 a job failed; 11 a job was cancelled.\n\n"
      "Examples:\n  sleight watch 17\n  sleight watch 17 --json --from 12\n  sleight watch g5");

  const auto awaited = std::make_shared<cli::JobsOptions>();
  command = add_command(app, "wait", "Wait until jobs end", action, cli::wait, awaited);
  add_jobs(*command, *awaited);
  command->footer(
      "Prints only how the jobs ended.\n\n"
      "Exit codes: 0 all jobs are done; 10 a job failed; 11 a job was cancelled.\n\n"
      "Example:\n  sleight wait 17 && sleight fetch 17");

  const auto logs = std::make_shared<cli::LogsOptions>();
  command = add_command(app, "logs", "Print the log of a job", action, cli::show_logs, logs);
  command->add_option("job", logs->job, "Job number (17)")->required()->type_name("JOB");
  command->add_flag("-f,--follow", logs->follow, "Keep printing new lines until the job ends");
  command
      ->add_option("--lines", logs->lines,
                   "Number of lines to print, counted from the end of the log")
      ->check(number_in(1U, k_lines_max).description(""))
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
  add("cancel", "Cancel jobs", rpc::ChangeKind::cancel,
      "A running job stops after its current scan and writes an archive of its results so far.\n\n"
      "Examples:\n  sleight cancel 17\n  sleight cancel g5\n  sleight cancel 17 19 23..30");
  add("hold", "Stop jobs until `sleight resume`", rpc::ChangeKind::hold,
      "No work is lost. After `sleight resume`, jobs produce the same archives as if they had not "
      "stopped.\n\n"
      "Example:\n  sleight hold 17");
  add("resume", "Resume held, failed or cancelled jobs", rpc::ChangeKind::resume,
      "Example:\n  sleight resume 17");
}

void add_priority(CLI::App& app, Action& action) {
  struct Options : cli::JobsOptions {
    std::int32_t priority = 0;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = add_command(
      app, "priority", "Set the priority of your jobs", action,
      [](const std::string& socket, const Options& given) {
        return cli::change(socket, given,
                           {.kind = rpc::ChangeKind::set_priority, .priority = given.priority});
      },
      options);
  add_jobs(*command, *options);
  command
      ->add_option("--to", options->priority,
                   "New priority; jobs with a higher priority run first. Jobs start with 0")
      ->required()
      ->check(number_in(-k_priority_max, k_priority_max))
      ->type_name("N");
  command->footer(
      "A priority matters only among jobs of the same user. Users share the machine fairly.\n"
      "A job with a higher priority replaces a running job of the same user after the running job\n"
      "has used its time slice (10 s by default).\n\n"
      "Examples:\n  sleight priority 17 --to 5\n  sleight priority g5 --to -1");
}

void add_extend(CLI::App& app, Action& action) {
  const auto options = std::make_shared<cli::ExtendOptions>();
  CLI::App* command = add_command(
      app, "extend", "Extend jobs to more scans, rounds or solutions", action,
      [](const std::string& socket, const cli::ExtendOptions& given) {
        return cli::change(
            socket, given,
            {.kind = rpc::ChangeKind::extend, .extension = cli::extension_of(given)});
      },
      options);
  add_jobs(*command, *options);
  CLI::App* rule = command->add_option_group(
      "[stop]", "Exactly one stopping rule, which replaces [stop] of the request");
  rule->add_option("--scans", options->scans, "Number of scans of each chain")
      ->check(number_in(std::uint64_t{1}, request::k_scans_max).description(""))
      ->type_name("N");
  rule->add_option("--rounds", options->rounds, "Number of rounds")
      ->check(number_in(1U, request::k_rounds_max))
      ->type_name("N");
  rule->add_option("--solutions", options->solutions, "Number of solutions")
      ->check(number_in(1U, request::k_independent_solutions_max))
      ->type_name("N");
  rule->add_option("--odds", options->odds, "Standard error of log P(satisfied), in nats")
      ->check(number_in(request::k_odds_min, request::k_odds_max))
      ->type_name("X");
  rule->require_option(1);
  command->footer(
      "The number is the new total of the whole run, not an amount to add. The archive is the\n"
      "same as if the request had contained the new number from the start.\n\n"
      "Examples:\n  sleight extend 17 --solutions 100\n  sleight extend g5 --scans 40000");
}

void add_fetch(CLI::App& app, Action& action) {
  const auto options = std::make_shared<cli::FetchOptions>();
  CLI::App* command = add_command(
      app, "fetch", "Download the archives of jobs", action,
      [](const std::string& socket, const cli::FetchOptions& given) {
        return cli::fetch(socket, given, cli::check_archive);
      },
      options);
  command->add_option("jobs", options->jobs, k_jobs_help)->required()->type_name("JOB");
  command
      ->add_option(
          "-o,--output", options->output,
          "Output file, or folder for several jobs. Default: job-NUMBER.h5, or gNUMBER for a group")
      ->type_name("FILE");
  command->add_flag("--so-far", options->so_far, "Fetch an archive of the results so far");
  command
      ->add_option("--recordings", options->recordings,
                   "Fetch kept animations by id (3,7,10..20) into a folder")
      ->type_name("IDS");
  command->add_flag("--failures", options->failures,
                    "Fetch the files of failed simulations, for `sleight replay`, into a folder");
  command->add_flag("--force", options->force, "Overwrite existing files");
  command->add_flag("-q,--quiet", options->quiet, "Don't show progress or file names");
  command->add_flag("--json", options->json, k_json_help);
  command->footer(
      "A file appears only when it is complete and its digest is correct. To resume a download,\n"
      "repeat the command. Without --force, an existing file with other content is an error.\n\n"
      "Examples:\n  sleight fetch 17 -o hi.h5\n  sleight fetch 17 --so-far -o hi_so_far.h5\n"
      "  sleight fetch g5\n"
      "  sleight fetch 17 --failures && sleight replay job-17-failures/failure-0-3-1760.toml");
}

void add_keeps(CLI::App& app, Action& action) {
  const auto deleted = std::make_shared<cli::DeleteOptions>();
  CLI::App* command =
      add_command(app, "delete", "Delete jobs that have ended, with their archives and logs",
                  action, cli::delete_jobs, deleted);
  add_jobs(*command, *deleted);
  command->add_flag("-y,--yes", deleted->yes, "Don't ask for confirmation");
  command->footer(
      "Deletes nothing if one of the jobs has not ended or is pinned. On a terminal, asks for\n"
      "confirmation.\n\n"
      "Examples:\n  sleight delete 17\n  sleight delete g5 -y");

  struct PinOptions : cli::JobsOptions {
    bool off = false;
  };
  const auto pinned = std::make_shared<PinOptions>();
  command = add_command(
      app, "pin", "Protect jobs from deletion", action,
      [](const std::string& socket, const PinOptions& given) {
        return cli::change(socket, given,
                           {.kind = given.off ? rpc::ChangeKind::unpin : rpc::ChangeKind::pin});
      },
      pinned);
  add_jobs(*command, *pinned);
  command->add_flag("--off", pinned->off, "Remove the protection");
  command->footer(
      "The service deletes old finished jobs (settings keep_days and keep_bytes, see\n"
      "`sleight config`), but never pinned jobs.\n\n"
      "Examples:\n  sleight pin 17\n  sleight pin 17 --off");
}

void add_server(CLI::App& app, Action& action) {
  CLI::App* server =
      app.add_subcommand("server", "Start, stop or inspect the service on this machine");
  server->require_subcommand(1);
  const auto start = std::make_shared<cli::ServerStartOptions>();
  CLI::App* command = server->add_subcommand("start", "Start the service in the background");
  add_setting_options(*command, start->given);
  command->add_flag("--foreground", start->foreground, "Run in the foreground until Ctrl-C");
  command->add_flag("--json", start->json, k_json_help);
  command->callback([&action, start] { action = [start] { return cli::start_server(*start); }; });
  command->footer(
      "Returns when the service answers. The log is server.log in the state folder. All settings\n"
      "have defaults; `sleight config` lists them. If the service is already running, the command\n"
      "changes nothing.\n\n"
      "Examples:\n  sleight server start\n  sleight server start --cores 8 --memory 24GB");

  const auto add = [&](const char* name, const char* help, auto run, const char* footer) {
    const auto json = std::make_shared<bool>(false);
    CLI::App* one = server->add_subcommand(name, help);
    one->add_flag("--json", *json, k_json_help);
    one->callback(
        [&action, json, run] { action = [json, run] { return run(service_called(), *json); }; });
    one->footer(footer);
  };
  add("stop", "Stop the service; jobs keep running", cli::stop_server,
      "The next `sleight server start` takes over the jobs.\n\n"
      "Example:\n  sleight server stop");
  add("drain", "Stop all running jobs cleanly and start no more jobs", cli::drain_server,
      "Drain the service before the machine shuts down. The next start of the service resumes the "
      "jobs.\n\n"
      "Example:\n  sleight server drain");
  add("status", "Show the state of the service", cli::show_server,
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
