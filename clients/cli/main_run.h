// Code for both programs that run requests: a run's options, reading the request, and the final
// summary. This code belongs to the main programs, which join clients and worker.
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

/// Options that replace a request's [stop].
struct AnswerOptions {
  std::optional<std::uint32_t> number{};  ///< -n
  bool found = false;
  bool in_proportion = false;

  /// Returns nothing if no option is given.
  std::optional<request::Asked> asked() const;
  /// Returns the options' text for errors, such as "--found -n 3".
  std::string words() const;
};

/// Adds -n, --found and --in-proportion.
void add_answer_options(CLI::App& app, AnswerOptions& options);

struct DirectArguments {
  std::string request_path;  ///< or a word for balls to spell
  std::string word;
  AnswerOptions answer;           ///< replaces the request's [stop]
  std::vector<std::string> sets;  ///< replace keys of the request (request::KeySet)
  bool print_request = false;     ///< print the request and exit
  std::string output;
  bool fresh = false;
  bool json = false;
  bool quiet = false;
  bool strict = false;            ///< a failed simulation ends the run
  bool errors_elsewhere = false;  ///< another rank prints the request's errors
  std::string time_limit;         ///< "20s", "5m", "1h"; empty: none
  std::string end_report;         ///< pipe for the end report; empty: none
  std::optional<std::uint64_t> seed;
  std::size_t threads = 0;  ///< 0: one per core
  std::size_t cache_mb = run::k_cache_bytes_max >> 20U;

  run::WorkerResources resources() const { return {.cache_bytes_max = cache_mb << 20U}; }
};

/// Adds the command line to bug reports, so that the bug can be repeated. read_request() also adds
/// the request and its seed. `launcher` precedes the command, such as "mpirun -n 3 ". Call it first
/// in main.
void note_what_repeats(int argc, const char* const* argv, const std::string& launcher = {});

void add_run_options(CLI::App& app, DirectArguments& arguments);

void add_sets_option(CLI::App& app, std::vector<std::string>& sets);

/// Returns a text that says what is wrong with the command line and whose help to read. Use as
/// CLI11's failure_message.
std::string usage_words(const CLI::App* app, const CLI::Error& error);

/// Builds the command line of `sleight-batch`. Both programs use this function, because `sleight
/// man` prints the page of `sleight-batch` too.
void build_batch_app(CLI::App& app, DirectArguments& arguments);

/// Returns the seconds of "90", "90s", "5m" or "1.5h". Throws base::Error(usage) for other texts.
double parse_duration_s(const std::string& text);

/// Reads the request's text. Throws base::Error(usage) if the request or the output file is
/// missing.
cli::GivenRequest given_request(const DirectArguments& arguments);

/// Prints the request for --print-request, and returns the exit code.
int print_request(const run::Catalogue& catalogue, const cli::GivenRequest& given,
                  const DirectArguments& arguments);

/// Reads and checks the request. Prints every error to stderr. If there is an error, returns
/// nothing.
std::optional<request::DirectionRequest> read_request(const run::Catalogue& catalogue,
                                                      cli::GivenRequest given,
                                                      const DirectArguments& arguments);

/// Runs a request with the crew. Prints progress to stderr and a summary to stdout. Returns the
/// exit code.
int run_and_report(const request::DirectionRequest& request, const run::Catalogue& catalogue,
                   DirectArguments arguments, coordinator::Crew& crew, cli::EndReport& end_report);

/// Ends the process without waiting for threads that still compute.
[[noreturn]] void leave_at_once(int code);

std::string version_text();

/// Prints the current exception as "program: message" and returns its exit code. For a bug, also
/// prints how to repeat it.
int report_failure(const std::string& program);

extern const char* const k_exit_codes;

}  // namespace sleight::programs
