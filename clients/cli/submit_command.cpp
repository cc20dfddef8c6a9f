#include "clients/cli/submit_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <thread>
#include <utility>

#include "clients/cli/job_watch.h"
#include "clients/cli/service_json.h"
#include "clients/service_client/service_call.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/config/quantities.h"
#include "common/request/direction_request.h"
#include "common/request/text.h"

namespace sleight::cli {
namespace {

constexpr std::size_t k_option_characters_max = 60;  // shown in an error

using Diagnostics = std::vector<request::Diagnostic>;

/// Maximum wait for the next server, if a server was killed between call and answer.
constexpr double k_away_s_max = 30;
constexpr double k_first_wait_s = 0.05;
constexpr double k_wait_s_max = 1;

std::uint64_t memory_of(const std::string& text) {
  if (text.empty()) return 0;
  const auto bytes = config::bytes_of(text);
  if (bytes && *bytes > 0) return *bytes;
  throw base::Error(base::ExitCode::usage,
                    fmt::format("--memory: expected a size such as 2GB or 500MB, found '{}'",
                                terminal::shown(text)));
}

std::string job_name(const SubmitOptions& options) {
  std::string name = options.name;
  if (name.empty()) name = short_name_of(options.request_path, options.word);
  // A job's name must be printable, but a file's name may contain any characters.
  name = request::printable(name, name.size());
  if (!options.name.empty() && name.size() > rpc::k_name_bytes_max) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("--name: {} bytes exceed the maximum of {} bytes", name.size(),
                                  rpc::k_name_bytes_max));
  }
  return name;
}

/// Returns the --set options that this request doesn't share with its group.
std::string what_differs(const std::vector<request::KeySet>& sets,
                         const std::vector<std::vector<request::KeySet>>& combinations) {
  std::string texts;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const bool differs = std::ranges::any_of(
        combinations, [&](const auto& other) { return other[i].text != sets[i].text; });
    if (differs) texts += " " + sets[i].text;
  }
  return texts;
}

/// Parses KEY=VALUE texts. If a key is repeated, its last value counts.
std::vector<rpc::JobOption> job_options_of(const std::vector<std::string>& texts) {
  std::map<std::string, std::string> values;
  for (const std::string& text : texts) {
    const std::size_t end = text.find('=');
    if (end == std::string::npos || end == 0) {
      throw base::Error(
          base::ExitCode::usage,
          fmt::format("--option: expected KEY=VALUE, such as partition=long, found '{}'",
                      request::printable(text, k_option_characters_max)));
    }
    values[text.substr(0, end)] = text.substr(end + 1);
  }
  std::vector<rpc::JobOption> options;
  for (const auto& [name, value] : values)
    options.push_back({.name = name, .value = value});
  return options;
}

/// Cuts a name to the service's limit, between characters.
std::string cut_name(std::string name) {
  while (name.size() > rpc::k_name_bytes_max)
    name = request::printable(name, request::character_count(name) - 4);
  return name;
}

void check_size(const rpc::Submission& submission) {
  std::size_t bytes = 0;
  for (const rpc::JobAsk& job : submission.jobs)
    bytes += job.request.size();
  if (bytes <= rpc::k_submission_bytes_max) return;
  throw base::Error(base::ExitCode::usage,
                    fmt::format("the {} requests have {} bytes, above the maximum of {} bytes per "
                                "submission; submit them in parts",
                                submission.jobs.size(), bytes, rpc::k_submission_bytes_max));
}

int print_diagnostics(const Diagnostics& diagnostics) {
  for (const request::Diagnostic& error : diagnostics)
    terminal::complain(request::to_string(error));
  return static_cast<int>(base::ExitCode::bad_request);
}

/// Adds the request's name to the service's errors, and makes them safe for a terminal.
Diagnostics named(Diagnostics diagnostics, const std::string& name) {
  for (request::Diagnostic& error : diagnostics) {
    error.file = terminal::shown(name);
    error.message = terminal::shown(error.message);
  }
  return diagnostics;
}

/// Submits, with retries. After a broken connection, the client itself retries. After a server was
/// killed, submit_surely waits longer. The submission's key prevents a duplicate.
rpc::Submitted submit_surely(rpc::Client& client, const rpc::Submission& submission) {
  double waited_s = 0;
  for (double wait_s = k_first_wait_s;; wait_s = std::min(2 * wait_s, k_wait_s_max)) {
    try {
      return client.submit(submission);
    } catch (const rpc::NoServer&) {
      if (waited_s >= k_away_s_max) throw;
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(wait_s));
    waited_s += wait_s;
  }
}

void tell(const SubmitOptions& options, const rpc::Submitted& submitted, bool draining) {
  if (options.json) {
    // With --watch, lines with events follow this output. With --wait, the ended job follows.
    fmt::print("{}\n",
               options.watch ? on_one_line(to_json(submitted)) : indented(to_json(submitted)));
  } else {
    fmt::print("{}", submitted_text(submitted, job_name(options)));
  }
  std::fflush(stdout);
  if (draining)
    terminal::complain(
        "the server is draining: no job starts until `sleight server start` is run again");
}

int submit_with(rpc::Client& client, const SubmitOptions& options, const GivenRequest& given,
                const rpc::Submission& submission) {
  // First check that a server exists. If the next call fails, the server exited in between.
  const bool draining = client.info().draining;
  rpc::Submitted submitted;
  try {
    submitted = submit_surely(client, submission);
  } catch (const rpc::RefusedError& error) {
    if (error.refusal().diagnostics.empty()) throw;
    return print_diagnostics(named(error.refusal().diagnostics, given.name));
  }
  if (!(options.wait && options.json)) tell(options, submitted, draining);
  if (!options.watch && !options.wait) return static_cast<int>(base::ExitCode::ok);
  std::vector<rpc::JobView> jobs;
  for (const rpc::JobId job : submitted.jobs)
    jobs.push_back(client.status(job));
  return watch_jobs(client, jobs, 1,
                    {.quiet = !options.watch, .json = options.json, .single = !submitted.group});
}

}  // namespace

base::Result<rpc::Submission, Diagnostics> submission_of(const SubmitOptions& options,
                                                         const GivenRequest& given,
                                                         const RequestTexts& texts) {
  const auto combinations = request::expand_sets(options.sets);
  if (!combinations) return combinations.error();
  if (const auto twice = given_twice(combinations.value().front(),
                                     {.word = !options.word.empty(), .answer = options.asked_by}))
    return std::vector{*twice};
  const std::size_t count = combinations.value().size();
  if (count > rpc::k_submission_jobs_max) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("--set defines {} jobs, above the maximum of {} per submission",
                                  count, rpc::k_submission_jobs_max));
  }
  // If the request was made from a word, its text already has the keys of `asked`.
  const auto asked = options.word.empty() ? options.asked : std::nullopt;
  const std::string name =
      asked ? fmt::format("{} with {}", given.name, options.asked_by) : given.name;
  rpc::Submission submission{
      .key = {}, .jobs = {}, .is_group = !request::plain_sets(options.sets).ok()};
  for (const std::vector<request::KeySet>& sets : combinations.value()) {
    std::string text = given.text;
    if (!sets.empty() || asked) {
      auto normalised = texts.normalised(given.text, name, sets, asked);
      if (!normalised) return normalised.error();
      text = std::move(normalised).value();
    }
    submission.jobs.push_back(
        {.name = cut_name(job_name(options) + what_differs(sets, combinations.value())),
         .request = std::move(text),
         .cores = options.cores,
         .ranks = options.ranks,
         .memory_bytes = memory_of(options.memory),
         .priority = options.priority,
         .strict = options.strict,
         .options = job_options_of(options.options)});
  }
  check_size(submission);
  return submission;
}

std::string submitted_text(const rpc::Submitted& submitted, const std::string& name) {
  const std::string id = submitted.group          ? fmt::format("g{}", *submitted.group)
                         : submitted.jobs.empty() ? "?"
                                                  : fmt::format("{}", submitted.jobs.front());
  const bool is_group = submitted.group.has_value();
  std::string text = is_group ? fmt::format("group {} of {} job{}", id, submitted.jobs.size(),
                                            submitted.jobs.size() == 1 ? "" : "s")
                              : "job " + id;
  text += fmt::format(" ({}){}\n", terminal::shown(name),
                      submitted.was_known ? ", already submitted" : "");
  const auto add = [&](const std::string& command, const std::string& what) {
    text += fmt::format("  sleight {:<20}{}\n", command, what);
  };
  add("watch " + id, "show progress");
  add("wait " + id, is_group ? "wait until all jobs end" : "wait until the job ends");
  add("fetch " + id, is_group ? "download the archives"
                              : "download the archive (while the job is running, add --so-far)");
  add("cancel " + id, is_group ? "cancel the jobs" : "cancel the job");
  return text;
}

int submit(const std::string& socket, const SubmitOptions& options, const RequestTexts& texts) {
  if (options.watch && options.wait)
    throw base::Error(base::ExitCode::usage, "--watch already waits; remove --wait");
  const GivenRequest given = given_request(options.request_path, options.word, options.asked);
  auto submission = submission_of(options, given, texts);
  if (!submission) return print_diagnostics(submission.error());
  rpc::Submission asked = std::move(submission).value();
  asked.key = rpc::random_key();
  return service_client::with_service(
      socket, [&](rpc::Client& client) { return submit_with(client, options, given, asked); });
}

}  // namespace sleight::cli
