#include "common/rpc/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "common/access/token_text.h"

namespace sleight::rpc {
namespace {

constexpr double k_extension_max = 9e15;  // below 2^53, so exact in a double

Refusal refuse(RefusalKind kind, std::string sentence, std::string what_to_do = {}) {
  return {.kind = kind,
          .sentence = std::move(sentence),
          .what_to_do = std::move(what_to_do),
          .diagnostics = {}};
}

/// Refuses text that could control a terminal.
bool is_printable(const std::string& text) {
  return std::none_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7F;
  });
}

Refusal newer_client(const char* what) {
  return refuse(
      RefusalKind::bad_request,
      fmt::format("The server is older than the client and doesn't support this {}.", what),
      "Restart the server with the newer program; running jobs keep running.");
}

std::optional<Refusal> check(const JobAsk& job) {
  if (job.name.size() > k_name_bytes_max || !is_printable(job.name)) {
    return refuse(RefusalKind::bad_request,
                  fmt::format("A job's name has at most {} bytes and no control characters.",
                              k_name_bytes_max),
                  "Choose another --name.");
  }
  if (job.request.size() > k_request_bytes_max) {
    return refuse(RefusalKind::limit,
                  fmt::format("A request has at most {} kB; this one has {} kB.",
                              k_request_bytes_max >> 10U, job.request.size() >> 10U));
  }
  if (job.options.size() > k_options_max) {
    return refuse(RefusalKind::limit,
                  fmt::format("A job has at most {} backend options.", k_options_max));
  }
  std::unordered_set<std::string> names;
  for (const JobOption& option : job.options) {
    if (option.name.empty() || option.name.size() > k_option_bytes_max ||
        option.value.size() > k_option_bytes_max || !is_printable(option.name) ||
        !is_printable(option.value) || !names.insert(option.name).second) {
      return refuse(RefusalKind::bad_request,
                    fmt::format("Each backend option needs a unique name; names and values have at "
                                "most {} bytes and no control characters.",
                                k_option_bytes_max));
    }
  }
  return std::nullopt;
}

}  // namespace

Refusal no_such_job() {
  return refuse(RefusalKind::not_found, "There is no such job or group.",
                "`sleight list` shows the existing jobs.");
}

std::optional<Refusal> check(Submission& submission) {
  if (submission.key.empty() || submission.key.size() > k_key_bytes_max ||
      !is_printable(submission.key)) {
    return refuse(
        RefusalKind::bad_request,
        fmt::format("A submission needs a key of 1 to {} printable bytes.", k_key_bytes_max));
  }
  if (submission.jobs.empty())
    return refuse(RefusalKind::bad_request, "A submission needs at least one job.");
  if (submission.jobs.size() > k_submission_jobs_max) {
    return refuse(RefusalKind::limit,
                  fmt::format("A submission has at most {} jobs.", k_submission_jobs_max),
                  "Submit the jobs in several groups.");
  }
  std::size_t bytes = 0;
  for (const JobAsk& job : submission.jobs) {
    if (auto refused = check(job)) return refused;
    bytes += job.request.size();
  }
  if (bytes > k_submission_bytes_max) {
    return refuse(
        RefusalKind::limit,
        fmt::format("A submission has at most {} MB of requests.", k_submission_bytes_max >> 20U),
        "Submit the jobs in several groups.");
  }
  if (submission.jobs.size() > 1) submission.is_group = true;
  return std::nullopt;
}

std::optional<Refusal> check(ListAsk& ask) {
  for (const JobState state : ask.states) {
    if (state == JobState::unknown) return newer_client("state of a job");
  }
  if (ask.states.size() >= k_job_states)
    return refuse(RefusalKind::bad_request, "The request names too many job states.");
  if (ask.name_part.size() > k_name_bytes_max || ask.cursor.size() > k_name_bytes_max)
    return refuse(RefusalKind::bad_request, "The name or the cursor is too long.");
  ask.count = std::clamp<std::uint32_t>(ask.count, 1, k_page_jobs_max);
  return std::nullopt;
}

std::optional<Refusal> check(ChangeAsk& ask) {
  const Target& target = ask.target;
  const std::uint64_t id = target.job ? target.job->value : target.group ? target.group->value : 0;
  if (id == 0) return no_such_job();
  if (ask.kind == ChangeKind::unknown) return newer_client("change of a job");
  if (ask.kind != ChangeKind::extend) return std::nullopt;
  const Extension& extension = ask.extension;
  if (extension.by == ExtendBy::unknown) return newer_client("way to extend a job");
  const bool is_whole = extension.to == std::floor(extension.to);
  if (!(extension.to > 0) || extension.to > k_extension_max ||
      (extension.by != ExtendBy::odds && !is_whole)) {
    return refuse(RefusalKind::bad_request,
                  "An extension's value must be above 0. Numbers of scans, rounds and solutions "
                  "must be integers.");
  }
  return std::nullopt;
}

std::optional<Refusal> check(LogAsk& ask) {
  if (ask.job.value == 0) return no_such_job();
  ask.bytes_max = std::clamp<std::uint32_t>(ask.bytes_max, 1, k_log_bytes_max);
  return std::nullopt;
}

std::optional<Refusal> check(FetchAsk& ask) {
  if (ask.job.value == 0) return no_such_job();
  if (ask.kind == FetchKind::unknown) return newer_client("kind of file");
  if (ask.ids.size() > k_fetch_ids_max) {
    return refuse(RefusalKind::limit,
                  fmt::format("At most {} recordings can be fetched at once.", k_fetch_ids_max),
                  "Fetch the archive instead; it contains all recordings.");
  }
  if (ask.kind == FetchKind::recordings && ask.ids.empty())
    return refuse(RefusalKind::bad_request, "No recording is named.", "Name at least one id.");
  if (ask.after.size() > k_name_bytes_max || ask.sha256_wanted.size() > k_key_bytes_max)
    return refuse(RefusalKind::bad_request, "The file's name or digest is too long.");
  return std::nullopt;
}

std::optional<Refusal> check(TokenAsk& ask) {
  if (!access::token_of(ask.token))
    return refuse(RefusalKind::bad_request, "The token is malformed.",
                  "`sleight token create` creates a token.");
  if (ask.name.empty() || ask.name.size() > k_name_bytes_max || !is_printable(ask.name)) {
    return refuse(RefusalKind::bad_request,
                  fmt::format("A token's name has 1 to {} bytes and no control characters.",
                              k_name_bytes_max),
                  "Choose another --name.");
  }
  if (ask.for_user == k_no_user) return refuse(RefusalKind::bad_request, "There is no such user.");
  if (ask.scopes.has_unknown) return newer_client("scope of a token");
  if (ask.scopes.bits == 0)
    return refuse(RefusalKind::bad_request, "A token needs at least one scope.");
  if (!(ask.valid_s >= 0) || ask.valid_s > k_token_s_max) {
    return refuse(RefusalKind::bad_request,
                  "A token must expire within ten years or never expire.");
  }
  return std::nullopt;
}

std::optional<Refusal> check(const std::vector<WatchPoint>& points) {
  if (points.empty()) return refuse(RefusalKind::bad_request, "No job to watch is named.");
  if (points.size() > k_watch_jobs_max) {
    return refuse(RefusalKind::limit,
                  fmt::format("At most {} jobs can be watched at once.", k_watch_jobs_max));
  }
  std::unordered_set<std::uint64_t> jobs;
  for (const WatchPoint& point : points) {
    if (!jobs.insert(point.job.value).second)
      return refuse(RefusalKind::bad_request, "A job is named twice.");
  }
  return std::nullopt;
}

}  // namespace sleight::rpc
