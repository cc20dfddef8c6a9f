#include "clients/cli/main_run.h"

#include <fmt/format.h>
#include <algorithm>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <system_error>
#include <variant>

#include "clients/analysis/run_counts.h"
#include "clients/cli/number_in.h"
#include "clients/cli/results_version.h"
#include "clients/terminal/progress_printer.h"
#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/base/memory.h"
#include "common/base/output_beside.h"
#include "common/base/version.h"
#include "common/config/quantities.h"
#include "common/events/progress.h"
#include "common/events/run_event.h"
#include "common/json/value.h"
#include "common/logging/log.h"
#include "common/request/nearest.h"
#include "common/request/sets.h"
#include "common/request/text.h"
#include "service/coordinator/stop_signal.h"

namespace sleight::programs {
namespace {

/// Prints a line to stderr. If printing fails, the exit code stays the same. Names of files or
/// bodies come from other people and must not affect a terminal.
void complain(std::string line) {
  std::ranges::replace_if(
      line, [](char c) { return (c >= 0 && c < ' ' && c != '\n' && c != '\t') || c == '\x7f'; },
      '?');
  std::fputs((line + "\n").c_str(), stderr);
}

const char* name_of(coordinator::DriveEnd end) {
  switch (end) {
    case coordinator::DriveEnd::finished:
      return "finished";
    case coordinator::DriveEnd::time_limit:
      return "time_limit";
    case coordinator::DriveEnd::stop_requested:
      return "interrupted";
    case coordinator::DriveEnd::simulation_failed:
      return "simulation_failed";
  }
  return "?";
}

json::Value handling_json(const coordinator::Handling& handling) {
  return {
      {"blocks", handling.counts.blocks},           {"copies", handling.counts.copies},
      {"refused", handling.counts.refused},         {"states_sent", handling.counts.states_sent},
      {"states_held", handling.counts.states_held}, {"messages", handling.traffic.messages},
      {"message_bytes", handling.traffic.bytes},    {"cache_hits", handling.cache.hits},
      {"cache_misses", handling.cache.misses},      {"cache_evictions", handling.cache.evictions},
      {"cache_bytes", handling.cache.bytes}};
}

/// Prints what the session computed, and the hit rate of the chain-state cache.
void print_effort(const coordinator::RunSummary& summary) {
  const events::Progress& progress = summary.progress;
  if (progress.session_simulations == 0) return;
  fmt::print("{} simulations in {} by {} worker{}", events::grouped(progress.session_simulations),
             events::clock_time(progress.elapsed_s), progress.workers,
             progress.workers == 1 ? "" : "s");
  const plan::CacheUse& cache = summary.handling.cache;
  const std::uint64_t asked = cache.hits + cache.misses;
  if (asked > 0) {
    fmt::print("; {:.1f}% of chain states were found in the cache",
               100.0 * static_cast<double>(cache.hits) / static_cast<double>(asked));
  }
  fmt::print("\n");
}

/// Prints the failed simulations of this session and of earlier sessions.
void print_failures(const DirectArguments& arguments, const coordinator::RunSummary& summary) {
  const plan::FailureCounts& failures = summary.progress.failures;
  if (failures.total() == 0) return;
  fmt::print(
      "{} simulation{} failed, and the run rejected {}: {}. This is a bug in the simulator; {}\n",
      events::grouped(failures.total()), failures.total() == 1 ? "" : "s",
      failures.total() == 1 ? "it" : "them", plan::to_string(failures),
      summary.first_failure.empty()
          ? fmt::format("see {}/failures.", coordinator::run_folder(arguments.output))
          : fmt::format("to repeat the first failure of this session, run `sleight replay {}`.",
                        summary.first_failure));
}

std::string what_is_missing(const coordinator::RunSummary& summary) {
  const plan::Finds& finds = summary.progress.finds;
  if (finds.is_all && finds.gave_up && finds.found == 0)
    return fmt::format("No archive: the search found nothing. {}", finds.gave_up_because);
  if (finds.is_all) return "No archive yet: the run stopped before the search found a solution.";
  if (summary.progress.odds.are_asked)
    return "No archive yet: the run stopped before the first island was complete.";
  return "No archive yet: the run stopped before every chain had a draw.";
}

void print_summary(const DirectArguments& arguments, const request::DirectionRequest& request,
                   const coordinator::RunSummary& summary) {
  if (arguments.json) {
    const json::Value json{
        {"archive", summary.digest.empty() ? "" : arguments.output},
        {"end", name_of(summary.end)},
        {"world", request.world},
        {"chains", request.sampler.chains},
        {"seed", request.sampler.seed},
        {"scans", summary.scans},
        {"session", summary.epoch},
        {"session_scans", summary.progress.session_scans},
        {"session_satisfied", summary.progress.session_satisfied},
        {"found", summary.found},
        {"found_in_proportion", false},
        {"takes", summary.relaxed},
        {"gave_up_because", summary.progress.finds.gave_up_because},
        {"independent_solutions", summary.progress.solutions},
        {"session_seconds", summary.progress.elapsed_s},
        {"session_simulations", summary.progress.session_simulations},
        {"workers", summary.progress.workers},
        {"failed_simulations", analysis::failures_json(summary.progress.failures)},
        {"handling", handling_json(summary.handling)},
        {"version", base::version()},
        {"results_version", results_version()},
        {"digest", summary.digest}};
    fmt::print("{}\n", json.dump(2));
    return;
  }
  if (summary.is_archive_given_up) {
    fmt::print(
        "Stopped while writing the archive: {} is unchanged, and all work is stored in {}.\n",
        arguments.output, coordinator::run_folder(arguments.output));
  } else if (summary.digest.empty()) {
    fmt::print("{}\n", what_is_missing(summary));
  } else if (summary.relaxed > 0) {
    fmt::print(
        "{}: {} takes (each found by search, then relaxed by {} scans); takes are not in the "
        "model's proportions; seed {}, digest {}\n",
        arguments.output, events::grouped(summary.relaxed),
        events::grouped(request.sampler.relax_scans.value_or(0)), request.sampler.seed,
        summary.digest);
  } else if (summary.scans == 0) {
    fmt::print("{}: {} found by search, not in the model's proportions; seed {}, digest {}\n",
               arguments.output, events::grouped(summary.found), request.sampler.seed,
               summary.digest);
  } else if (summary.progress.odds.are_asked) {
    fmt::print("{}: {}; seed {}, digest {}\n", arguments.output,
               events::odds_in_words(summary.progress.odds), request.sampler.seed, summary.digest);
  } else {
    fmt::print("{}: {} chain{} of {} scans, seed {}, digest {}\n", arguments.output,
               request.sampler.chains, request.sampler.chains == 1 ? "" : "s",
               events::grouped(summary.scans), request.sampler.seed, summary.digest);
  }
  if (!summary.digest.empty() && summary.progress.finds.gave_up)
    fmt::print("The search gave up. {}\n", summary.progress.finds.gave_up_because);
  print_effort(summary);
  print_failures(arguments, summary);
  if (summary.end == coordinator::DriveEnd::simulation_failed) {
    fmt::print("Stopped by --strict. To resume, repeat the command without --strict.\n");
  } else if (summary.end != coordinator::DriveEnd::finished) {
    fmt::print("Stopped early. To resume, repeat the command.\n");
  }
}

}  // namespace

const char* const k_exit_codes =
    "Exit codes: 0 success (also at a time limit, or if a search finds nothing); 1 bug;\n"
    "2 wrong usage; 3 errors in the request; 4 output belongs to another request, another\n"
    "results version or a running process; 5 system error (disk, files, memory); 6 invalid "
    "archive;\n"
    "7 chains have not mixed or cannot be judged, or weighted draws have too small an effective\n"
    "size (diagnose); 8 simulation failed (--strict, replay); 9 not allowed; 10 job failed (wait,\n"
    "watch); 11 job cancelled (wait, watch); 12 service not running; 130 interrupted, all work\n"
    "stored; 134 internal check failed (bug); 141 the reader of the output closed it.";

void note_what_repeats(int argc, const char* const* argv, const std::string& launcher) {
  base::report_uncaught_exceptions();
  base::add_repeat_note(fmt::format("to repeat: {}{}", launcher, base::command_line(argc, argv)));
}

std::string usage_words(const CLI::App* app, const CLI::Error& error) {
  std::string command = app->get_name();
  for (auto below = app->get_subcommands(); !below.empty(); below = app->get_subcommands()) {
    app = below.front();
    command += " " + app->get_name();
  }
  std::string words = error.what();
  if (words == "A subcommand is required") {
    std::vector<std::string> names;
    for (const CLI::App* below : app->get_subcommands([](const CLI::App*) { return true; }))
      names.push_back(below->get_name());
    const std::vector<std::string> rest = app->remaining();
    const auto unknown =
        std::ranges::find_if(rest, [](const std::string& word) { return !word.starts_with('-'); });
    words = "expected a command";
    if (unknown == rest.end()) {
      if (!rest.empty())
        words = fmt::format("unknown option '{}'", request::printable(rest.front(), 40));
    } else {
      const auto near = request::nearest(*unknown, names);
      words = fmt::format("unknown command '{}'{}", request::printable(*unknown, 40),
                          near ? fmt::format("; did you mean '{}'?", *near) : "");
    }
  }
  return fmt::format("{}: {}\nFor help, run `{} --help`.\n", command, words, command);
}

void add_run_options(CLI::App& app, DirectArguments& arguments) {
  CLI::Option* request = app.add_option("request", arguments.request_path,
                                        "Direction request (TOML). -: standard input")
                             ->type_name("REQUEST.toml");
  app.add_option("--word", arguments.word,
                 "Spell this word with balls, instead of reading a request")
      ->excludes(request)
      ->type_name("WORD");
  add_answer_options(app, arguments.answer);
  add_sets_option(app, arguments.sets);
  app.add_flag("--print-request", arguments.print_request, "Print the request and exit");
  app.add_option("-o,--output", arguments.output,
                 "Archive to write, NAME.h5. The run itself is stored in the folder NAME.h5.run")
      ->type_name("OUTPUT.h5");
  app.add_flag("--fresh", arguments.fresh,
               "Discard an earlier run of this output and start from scratch");
  app.add_option("--time-limit", arguments.time_limit,
                 "Stop cleanly after this time (20s, 5m, 1.5h). To resume, repeat the command. "
                 "Default: none")
      ->type_name("TIME");
  app.add_option("--seed", arguments.seed, "Random seed. Default: the request's")
      ->check(number_in(std::uint64_t{0}, request::k_seed_max))
      ->type_name("N");
  app.add_option("--cache", arguments.cache_mb,
                 "Size of the simulation cache of each process, in MB. Affects speed, not results")
      ->check(number_in(0, 1'000'000))
      ->type_name("MB")
      ->capture_default_str();
  app.add_flag("--json", arguments.json, "Print the summary as JSON");
  app.add_flag("--strict", arguments.strict,
               "Stop the run if a simulation fails. Default: reject the proposal and continue");
  app.add_flag("-q,--quiet", arguments.quiet, "Don't show progress");
  app.add_option(
         "--end-report", arguments.end_report,
         "Named pipe (mkfifo) for a supervisor; gets one line of JSON when the session ends")
      ->type_name("PIPE");
}

std::optional<request::Asked> AnswerOptions::asked() const {
  if (!number && !found && !in_proportion) return std::nullopt;
  request::Asked asked{.answer = {}, .number = number.value_or(request::k_solutions_asked_for)};
  if (found) asked.answer = request::Answer::found;
  if (in_proportion) asked.answer = request::Answer::in_proportion;
  return asked;
}

std::string AnswerOptions::words() const {
  std::string words = found ? "--found" : in_proportion ? "--in-proportion" : "";
  if (number) words += fmt::format("{}-n {}", words.empty() ? "" : " ", *number);
  return words;
}

void add_answer_options(CLI::App& app, AnswerOptions& options) {
  app.add_option("-n,--number", options.number,
                 "Number of animations; replaces [stop] of the request. Default without [stop]: 5")
      ->check(number_in(1U, request::k_independent_solutions_max))
      ->type_name("N");
  CLI::Option* found =
      app.add_flag("--found", options.found,
                   "Return solutions found by search; do not relax them by Markov chains");
  app.add_flag("--in-proportion", options.in_proportion,
               "Draw independent solutions, each as often as the model predicts. May take long")
      ->excludes(found);
}

void add_sets_option(CLI::App& app, std::vector<std::string>& sets) {
  app.add_option("--set", sets,
                 "Override a key of the request, for example sampler.seed=7. Repeatable")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
}

void build_batch_app(CLI::App& app, DirectArguments& arguments) {
  app.name("sleight-batch");
  app.failure_message(usage_words);
  app.description(
      "Runs a direction request on the ranks of an MPI job. The archive does not depend on the "
      "number\nof ranks.");
  app.set_version_flag("--version", version_text());
  add_run_options(app, arguments);
  app.footer(std::string("Examples:\n  sleight-batch requests/ball_2d.toml -o ball.h5\n"
                         "  mpirun -n 3 sleight-batch requests/ball_2d.toml -o ball.h5\n\n") +
             k_exit_codes);
}

std::string version_text() {
  return fmt::format("sleight {}\nresults {}", base::version(), results_version());
}

double parse_duration_s(const std::string& text) {
  const std::optional<double> duration_s = config::duration_s_of(text);
  if (duration_s) return *duration_s;
  throw base::Error(
      base::ExitCode::usage,
      fmt::format("--time-limit: expected a time such as 20s, 5m or 1.5h, found '{}'", text));
}

cli::GivenRequest given_request(const DirectArguments& arguments) {
  const bool is_given = !arguments.request_path.empty() || !arguments.word.empty();
  if (is_given && arguments.output.empty() && !arguments.print_request)
    throw base::Error(base::ExitCode::usage, "-o OUTPUT.h5 is required");
  return cli::given_request(arguments.request_path, arguments.word, arguments.answer.asked());
}

namespace {

using Read = base::Result<request::DirectionRequest, std::vector<request::Diagnostic>>;

/// `asked`: replaces the request's [stop], if set.
Read read(const run::Catalogue& catalogue, const cli::GivenRequest& given,
          std::optional<request::Asked> asked, const DirectArguments& arguments) {
  const auto sets = request::plain_sets(arguments.sets);
  if (!sets) return sets.error();
  const cli::OptionsGiven options{.seed = arguments.seed.has_value(),
                                  .word = arguments.request_path.empty(),
                                  .answer = arguments.answer.words()};
  if (const auto twice = cli::given_twice(sets.value(), options)) return std::vector{*twice};
  return request::read_request_with(given.text, given.name, catalogue.bindings(), sets.value(),
                                    asked);
}

}  // namespace

std::optional<request::DirectionRequest> read_request(const run::Catalogue& catalogue,
                                                      cli::GivenRequest given,
                                                      const DirectArguments& arguments) {
  const auto asked = arguments.request_path.empty() ? std::nullopt : arguments.answer.asked();
  if (asked) given.name += " with " + arguments.answer.words();
  Read read_one = read(catalogue, given, asked, arguments);
  if (!read_one) {
    for (const request::Diagnostic& error : read_one.error()) {
      if (!arguments.errors_elsewhere) complain(request::to_string(error));
    }
    return std::nullopt;
  }
  request::DirectionRequest request = std::move(read_one).value();
  if (arguments.seed) request = request::with_seed(std::move(request), *arguments.seed);
  base::add_repeat_note(fmt::format("request {}, world {}, seed {}, version {}", given.name,
                                    request.world, request.sampler.seed, base::version()));
  return request;
}

int print_request(const run::Catalogue& catalogue, const cli::GivenRequest& given,
                  const DirectArguments& arguments) {
  const auto request = read_request(catalogue, given, arguments);
  if (!request) return static_cast<int>(base::ExitCode::bad_request);
  const bool is_short = arguments.request_path.empty() && arguments.sets.empty() && !arguments.seed;
  fmt::print("{}", is_short ? given.text : request::normalised_text(*request));
  return static_cast<int>(base::ExitCode::ok);
}

int run_and_report(const request::DirectionRequest& request, const run::Catalogue& catalogue,
                   DirectArguments arguments, coordinator::Crew& crew, cli::EndReport& end_report) {
  arguments.output = base::where_links_lead(arguments.output);
  const base::SteadyClock clock;
  const bool is_of_chains = request.sampler.method != request::Method::sequential &&
                            request.sampler.start == request::Start::prior;
  if (is_of_chains && request.stop.independent_solutions && !request.stop.scans &&
      !request.stop.rounds) {
    logging::warn(
        "the run stops only after enough independent solutions, and may never stop; to limit it, "
        "set scans under [stop], or use --time-limit for this session");
  }
  const run::WorldEntry& world = catalogue.world_of(request);
  const bool in_proportion = request.stop.independent_solutions.has_value();
  if (const std::string past = world.past_effort(request); in_proportion && !past.empty())
    logging::info(past);
  const auto reader = world.make_reader(request);
  if (!reader->layout().warning.empty()) logging::warn(reader->layout().warning);
  const auto plan = run::make_plan(request, world, {});
  base::PosixFileSystem files;
  terminal::ProgressPrinter printer(request.world, stderr);
  coordinator::RunOptions options{
      .output = arguments.output,
      .fresh = arguments.fresh,
      .stop_requested = &coordinator::stop_requested,
      .strict = arguments.strict,
      .ended = [&](const events::RunEnd& end) { end_report.tell(end); }};
  if (!arguments.time_limit.empty()) options.time_limit_s = parse_duration_s(arguments.time_limit);
  if (!arguments.quiet) {
    options.hear = [&](const events::RunEvent& event) {
      if (const auto* progress = std::get_if<events::Progress>(&event.what))
        printer.show(*progress);
      if (const auto* phase = std::get_if<events::Phase>(&event.what)) printer.say(phase->words);
    };
  }
  const coordinator::RunSummary summary = coordinator::run_request(
      {.request = request,
       .reader = *reader,
       .plan = *plan,
       .plan_of = [&](const request::Cut& cut) { return run::make_plan(request, world, cut); },
       .crew = crew,
       .clock = clock,
       .files = files,
       .results_version = std::string(results_version())},
      options);
  printer.finish();
  print_summary(arguments, request, summary);
  return static_cast<int>(coordinator::exit_code_of(summary.end));
}

void leave_at_once(int code) {
  const bool is_told = std::fflush(nullptr) == 0;
  std::_Exit(is_told ? code : static_cast<int>(base::ExitCode::environment));
}

int report_failure(const std::string& program) {
  try {
    throw;
  } catch (const base::Error& error) {
    complain(fmt::format("{}: {}", program, error.what()));
    if (error.exit_code() == base::ExitCode::bug) std::fputs(base::repeat_notes().c_str(), stderr);
    return static_cast<int>(error.exit_code());
  } catch (const std::bad_alloc&) {
    complain(fmt::format("{}: {}", program, base::k_too_little_memory));
    return static_cast<int>(base::ExitCode::environment);
  } catch (const std::exception& error) {
    // Starting a thread fails with these errors.
    const auto* failed = dynamic_cast<const std::system_error*>(&error);
    if (failed != nullptr && (failed->code() == std::errc::resource_unavailable_try_again ||
                              failed->code() == std::errc::not_enough_memory)) {
      complain(fmt::format("{}: {}, or there are too many processes (ulimit -u)", program,
                           base::k_too_little_memory));
      return static_cast<int>(base::ExitCode::environment);
    }
    complain(fmt::format("{}: unexpected error: {}", program, error.what()));
    std::fputs(base::repeat_notes().c_str(), stderr);
    return static_cast<int>(base::ExitCode::bug);
  }
}

}  // namespace sleight::programs
