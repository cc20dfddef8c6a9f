// What the two programs that run requests share: options of a run, reading the request, and the
// summary at the end. Part of the programs' mains, where the sides are joined.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/end_report.h"
#include "clients/cli/given_request.h"
#include "common/request/direction_request.h"
#include "service/coordinator/run.h"
#include "worker/run/catalogue.h"

namespace sleight::programs {

/// What a command line asks for in the place of a request's [stop].
struct AnswerOptions {
  std::optional<std::uint32_t> number{};  ///< -n
  bool found = false;
  bool in_proportion = false;

  /// None: nothing.
  std::optional<request::Asked> asked() const;
  /// What asks for it, for errors: "--found -n 3".
  std::string words() const;
};

/// -n, --found and --in-proportion.
void add_answer_options(CLI::App& app, AnswerOptions& options);

/// As the command line gives them.
struct DirectArguments {
  std::string request_path;       ///< or, in its place,
  std::string word;               ///< that balls spell
  AnswerOptions answer;           ///< in place of the request's [stop]
  std::vector<std::string> sets;  ///< keys in place of the request's (request::KeySet)
  bool print_request = false;     ///< and do nothing else
  std::string output;
  bool fresh = false;
  bool json = false;
  bool quiet = false;
  bool strict = false;            ///< a simulation that fails ends the run
  bool errors_elsewhere = false;  ///< another rank prints the request's errors
  std::string time_limit;         ///< "20s", "5m", "1h"; empty for none
  std::string end_report;         ///< a pipe that hears how the session ended; empty for none
  std::optional<std::uint64_t> seed;
  std::size_t threads = 0;  ///< 0: one a core
  std::size_t cache_mb = run::k_cache_bytes_max >> 20U;

  run::WorkerResources resources() const { return {.cache_bytes_max = cache_mb << 20U}; }
};

/// From now on a bug is reported with what repeats it: the command line, and from read_request
/// on the request and its seed. `launcher` stands before the command ("mpirun -n 3 "). For a main's
/// first line.
void note_what_repeats(int argc, const char* const* argv, const std::string& launcher = {});

void add_run_options(CLI::App& app, DirectArguments& arguments);

/// --set, which may be repeated.
void add_sets_option(CLI::App& app, std::vector<std::string>& sets);

/// What is wrong with a command line, and which command's help to read: for CLI11's
/// failure_message.
std::string usage_words(const CLI::App* app, const CLI::Error& error);

/// The command line of `sleight-batch`: here, since `sleight man` has its page too.
void build_batch_app(CLI::App& app, DirectArguments& arguments);

/// Seconds of "90", "90s", "5m" or "1.5h". Throws base::Error(usage) for anything else.
double parse_duration_s(const std::string& text);

/// The request's text, which is read once. Throws base::Error: usage where there is no request, or
/// no output for it.
cli::GivenRequest given_request(const DirectArguments& arguments);

/// --print-request: shows the request, and returns the exit code.
int print_request(const run::Catalogue& catalogue, const cli::GivenRequest& given,
                  const DirectArguments& arguments);

/// Reads and checks the request; prints every error to stderr. None when there were any.
std::optional<request::DirectionRequest> read_request(const run::Catalogue& catalogue,
                                                      cli::GivenRequest given,
                                                      const DirectArguments& arguments);

/// Runs a read request with the given crew, with progress on stderr and a summary on stdout.
/// Returns the exit code.
int run_and_report(const request::DirectionRequest& request, const run::Catalogue& catalogue,
                   DirectArguments arguments, coordinator::Crew& crew, cli::EndReport& end_report);

/// Ends the process while threads compute what nobody waits for.
[[noreturn]] void leave_at_once(int code);

/// What --version says.
std::string version_text();

/// Prints a base::Error or any other exception as "program: message" and gives its exit code; of a
/// bug also what repeats it.
int report_failure(const std::string& program);

extern const char* const k_exit_codes;

}  // namespace sleight::programs
