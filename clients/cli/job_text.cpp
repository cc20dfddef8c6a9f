#include "clients/cli/job_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <vector>

#include "clients/cli/service_json.h"
#include "clients/report/text_table.h"
#include "common/events/progress.h"
#include "common/request/text.h"

namespace sleight::cli {
namespace {

constexpr std::size_t k_name_characters_max = 24;
/// A time beyond the year 9999 is invalid.
constexpr double k_time_s_max = 253'370'764'800.0;

std::string count_of(std::uint64_t count, std::uint64_t wanted) {
  if (wanted > 0) return fmt::format("{}/{}", events::grouped(count), events::grouped(wanted));
  return count > 0 ? events::grouped(count) : "";
}

std::string time_left(const std::optional<double>& left_s) {
  return left_s ? events::clock_time(*left_s) : "";
}

std::string percent_of(const rpc::JobView& job) {
  if (job.scans_total == 0) return "";
  const double share =
      static_cast<double>(job.scans_done) / static_cast<double>(job.scans_total) * 100;
  return fmt::format("{:.0f}%", std::floor(std::min(share, 100.0)));
}

std::string scans_cell(const rpc::JobView& job) {
  const std::string count = count_of(job.scans_done, job.scans_total);
  return job.scans_total == 0 ? count : fmt::format("{} {}", count, percent_of(job));
}

std::string rate_cell(const rpc::JobView& job) {
  if (!(job.simulations_per_s >= 1) || !(job.simulations_per_s < 1e15)) return "";
  return events::grouped(static_cast<std::uint64_t>(job.simulations_per_s));
}

/// Returns a job's text. Empty if the text only repeats the state, such as "Cancelled."
std::string unless_its_state(const rpc::JobView& job, const std::string& words) {
  std::string plain;
  for (const char c : words) {
    if (c != '.') plain += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return plain == rpc::name_of(job.state) ? std::string() : terminal::shown_on_one_line(words);
}

std::string reason_of(const rpc::JobView& job) {
  return unless_its_state(job, job.reason);
}

std::string why(const rpc::JobView& job) {
  switch (job.state) {
    case rpc::JobState::queued:
      return terminal::shown(job.not_yet.empty() ? job.reason : job.not_yet);
    case rpc::JobState::yielding:
    case rpc::JobState::held:
    case rpc::JobState::failed:
    case rpc::JobState::cancelled:
    case rpc::JobState::unknown:
    case rpc::JobState::starting:
      return reason_of(job);
    case rpc::JobState::running:
    case rpc::JobState::done:
      return "";
  }
  return "";
}

std::string state_name(rpc::JobState state) {
  return std::string(rpc::name_of(state));
}

std::string with_time_left(std::string text, const std::optional<double>& left_s) {
  if (left_s) text += fmt::format(", {} left", events::clock_time(*left_s));
  return text;
}

std::string state_line(const rpc::JobView& job) {
  std::string line = state_name(job.state);
  if (job.attempt > 1) line += fmt::format(", start {}", job.attempt);
  const std::string reason = reason_of(job);
  if (!reason.empty()) line += fmt::format(": {}", reason);
  return line;
}

std::string queue_line(const rpc::JobView& job) {
  std::string line = job.place > 0 ? fmt::format("place {}", events::grouped(job.place)) : "";
  if (!job.not_yet.empty()) line += (line.empty() ? "" : ": ") + terminal::shown(job.not_yet);
  return line;
}

std::string scans_line(const rpc::JobView& job) {
  if (job.scans_done == 0 && job.scans_total == 0) return "";
  std::string line = events::grouped(job.scans_done);
  if (job.scans_total > 0)
    line += fmt::format(" of {} ({})", events::grouped(job.scans_total), percent_of(job));
  return with_time_left(std::move(line), job.left_s);
}

std::string of_wanted(std::uint64_t count, std::uint64_t wanted) {
  if (wanted == 0) return count == 0 ? "" : events::grouped(count);
  return fmt::format("{} of {}", events::grouped(count), events::grouped(wanted));
}

std::string resources_line(const rpc::JobView& job) {
  std::vector<std::string> parts;
  const auto cores = [](std::uint32_t count) {
    return fmt::format("{} core{}", count, count == 1 ? "" : "s");
  };
  if (job.cores > 0) parts.push_back(cores(job.cores) + " now");
  parts.push_back(job.cores_wanted ? "maximum " + cores(*job.cores_wanted) : "uses all free cores");
  if (job.ranks > 0) parts.push_back(fmt::format("{} MPI ranks", job.ranks));
  if (job.memory_bytes > 0)
    parts.push_back(fmt::format("{} of simulation cache", size_text(job.memory_bytes)));
  if (job.priority != 0) parts.push_back(fmt::format("priority {}", job.priority));
  if (job.strict) parts.emplace_back("--strict");
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string times_line(const rpc::JobView& job) {
  std::string line = "submitted " + local_time(job.submitted_s);
  if (job.started_s > 0) line += ", started " + local_time(job.started_s);
  if (job.ended_s > 0) line += ", ended " + local_time(job.ended_s);
  return line;
}

std::string kept_line(const rpc::JobView& job) {
  std::string line = job.bytes > 0 ? size_text(job.bytes) : "";
  if (job.pinned) return line + (line.empty() ? "" : ", ") + "pinned";
  if (job.deleted_at_s > 0) {
    line += fmt::format("{}deleted after {}; to prevent this, run `sleight pin {}`",
                        line.empty() ? "" : ", ", local_time(job.deleted_at_s), job.id);
  }
  return line;
}

}  // namespace

std::string local_time(double time_s) {
  if (!(time_s > 0 && time_s < k_time_s_max)) return "-";
  const auto seconds = static_cast<std::time_t>(time_s);
  std::tm local{};
  if (::localtime_r(&seconds, &local) == nullptr) return "-";
  char text[32];
  const std::size_t length = std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &local);
  return {text, length};
}

std::string size_text(std::uint64_t bytes) {
  constexpr std::array<const char*, 6> k_units = {"B", "kB", "MB", "GB", "TB", "PB"};
  auto size = static_cast<double>(bytes);
  std::size_t unit = 0;
  // Use the next unit if three digits would round up to 1000.
  while (size >= 999.5 && unit + 1 < k_units.size()) {
    size /= 1000;
    ++unit;
  }
  return fmt::format("{:.3g} {}", size, k_units[unit]);
}

std::string name_of_job(const rpc::JobView& job) {
  return request::printable(job.name.empty() ? job.world : job.name, k_name_characters_max);
}

std::string solutions_text(const rpc::SolutionCounts& counts) {
  std::vector<std::string> parts;
  const std::string found = of_wanted(counts.found, counts.found_wanted);
  const std::string in_proportion = of_wanted(counts.in_proportion, counts.in_proportion_wanted);
  if (!found.empty()) parts.push_back(found + " found");
  if (!in_proportion.empty()) parts.push_back(in_proportion + " in proportion");
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string failures_text(std::span<const rpc::FailureCount> failures) {
  std::vector<std::string> parts;
  for (const rpc::FailureCount& failure : failures) {
    if (failure.count > 0)
      parts.push_back(fmt::format("{} {}", terminal::shown(failure.simulation),
                                  events::grouped(failure.count)));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string job_table(std::span<const rpc::JobView> jobs, const TableLook& look) {
  report::TextTable table;
  table.columns = {{.head = "ID", .to_the_right = true},
                   {.head = "NAME", .rank = 1},
                   {.head = "GROUP", .rank = 8},
                   {.head = "USER", .rank = 6},
                   {.head = "STATE"},
                   {.head = "PLACE", .to_the_right = true, .rank = 2},
                   {.head = "SCANS", .to_the_right = true, .rank = 3},
                   {.head = "FOUND", .to_the_right = true, .rank = 4},
                   {.head = "IN PROPORTION", .to_the_right = true, .rank = 4},
                   {.head = "SIMS/S", .to_the_right = true, .rank = 9},
                   {.head = "LEFT", .to_the_right = true, .rank = 5},
                   {.head = "TO SOLUTIONS", .to_the_right = true, .rank = 7},
                   {.head = "FAILED", .rank = 4},
                   {.head = "WHY", .rank = 1}};
  for (const rpc::JobView& job : jobs) {
    table.rows.push_back(
        {fmt::format("{}", job.id), name_of_job(job),
         job.group ? fmt::format("g{}", *job.group) : "",
         look.with_users && look.user_name ? terminal::shown(look.user_name(job.user)) : "",
         state_name(job.state), job.place > 0 ? events::grouped(job.place) : "", scans_cell(job),
         count_of(job.solutions.found, job.solutions.found_wanted),
         count_of(job.solutions.in_proportion, job.solutions.in_proportion_wanted), rate_cell(job),
         time_left(job.left_s), time_left(job.solutions_left_s), failures_text(job.failures),
         why(job)});
  }
  return to_text(table, look.width);
}

report::Report job_report(const rpc::JobView& job) {
  report::Report report;
  report.for_programs("id", job.id.value);
  report.for_programs("group", group_json(job.group));
  report.for_programs("user", job.user);
  report.for_programs("name", job.name);
  report.for_programs("world", job.world);
  report.add("state", rpc::name_of(job.state), "state", state_line(job));
  report.for_programs("reason", job.reason);
  report.add("place", job.place > 0 ? Json(job.place) : Json(), "queue", queue_line(job));
  report.for_programs("not_yet", job.not_yet);
  report.for_programs("starts", job.attempt);
  report.add("scans_done", job.scans_done, "scans", scans_line(job));
  report.for_programs("scans_total", job.scans_total > 0 ? Json(job.scans_total) : Json());
  report.for_programs("left_seconds", optional_json(job.left_s));
  const rpc::SolutionCounts& solutions = job.solutions;
  report.add("found", solutions.found, "found", of_wanted(solutions.found, solutions.found_wanted));
  report.for_programs("found_wanted", solutions.found_wanted);
  const std::string in_proportion =
      of_wanted(solutions.in_proportion, solutions.in_proportion_wanted);
  report.add(
      "in_proportion", solutions.in_proportion, "in proportion",
      in_proportion.empty() ? in_proportion : with_time_left(in_proportion, job.solutions_left_s));
  report.for_programs("in_proportion_wanted", solutions.in_proportion_wanted);
  report.for_programs("solutions_left_seconds", optional_json(job.solutions_left_s));
  const std::string rate = rate_cell(job);
  report.add("simulations_per_second", job.simulations_per_s, "rate",
             rate.empty() ? rate : rate + " simulations per second");
  report.add("failed_simulations", failures_json(job.failures), "failures",
             failures_text(job.failures));
  report.for_people("resources", resources_line(job));
  report.for_programs("cores_wanted", optional_json(job.cores_wanted));
  report.for_programs("cores", job.cores);
  report.for_programs("ranks", job.ranks);
  report.for_programs("memory_bytes", job.memory_bytes);
  report.for_programs("priority", job.priority);
  report.for_programs("strict", job.strict);
  report.for_people("times", times_line(job));
  report.for_programs("submitted", time_json(job.submitted_s));
  report.for_programs("started", time_json(job.started_s));
  report.for_programs("ended", time_json(job.ended_s));
  report.add("core_seconds", job.core_s, "spent",
             job.core_s > 0 ? events::clock_time(job.core_s) + " of processor time" : "");
  report.add("bytes", job.bytes, "kept", kept_line(job));
  report.for_programs("pinned", job.pinned);
  report.for_programs("deleted_at", time_json(job.deleted_at_s));
  report.add("digest", job.digest, "archive",
             job.digest.empty() ? "" : "digest " + terminal::shown(job.digest));
  report.for_programs("results_version", job.results_version);
  report.add("end_words", job.end_words, "end", terminal::shown_on_one_line(job.end_words));
  report.for_programs("last_log_lines", job.last_log_lines);
  for (const std::string& line : job.last_log_lines)
    report.for_people("log", terminal::shown(line));
  report.add("repeat_command", job.repeat_command, "to repeat",
             terminal::shown(job.repeat_command));
  return report;
}

std::string job_text(const rpc::JobView& job) {
  const std::string world = job.name.empty() || job.name == job.world
                                ? ""
                                : fmt::format(" ({})", terminal::shown(job.world));
  const std::string group = job.group ? fmt::format(", group g{}", *job.group) : "";
  return fmt::format("job {}  {}{}{}\n", job.id, name_of_job(job), world, group) +
         job_report(job).as_text(2, 14);
}

std::string history_text(const rpc::JobView& job) {
  report::TextTable table{.columns = {{.head = "NUMBER", .to_the_right = true},
                                      {.head = "TIME"},
                                      {.head = "STATE"},
                                      {.head = "START", .to_the_right = true},
                                      {.head = "REASON"}},
                          .rows = {}};
  for (const rpc::StateChange& change : job.history) {
    table.rows.push_back({fmt::format("{}", change.number), local_time(change.time_s),
                          state_name(change.state),
                          change.attempt > 0 ? fmt::format("{}", change.attempt) : "",
                          terminal::shown_on_one_line(change.reason)});
  }
  return to_text(table, std::nullopt);
}

std::string end_line(const rpc::JobView& job) {
  std::vector<std::string> parts;
  const std::string solutions = solutions_text(job.solutions);
  if (!solutions.empty()) parts.push_back(solutions);
  if (job.scans_done > 0) parts.push_back(events::grouped(job.scans_done) + " scans");
  const std::string failures = failures_text(job.failures);
  if (!failures.empty()) parts.push_back("simulations FAILED: " + failures);
  if (job.core_s > 0) parts.push_back(events::clock_time(job.core_s) + " of processor time");
  std::string line = fmt::format("{} {} {}", job.id, name_of_job(job), state_name(job.state));
  if (!parts.empty()) line += fmt::format(": {}", fmt::join(parts, ", "));
  const std::string words =
      unless_its_state(job, job.end_words.empty() ? job.reason : job.end_words);
  if (job.state != rpc::JobState::done && !words.empty()) line += fmt::format(". {}", words);
  return line;
}

std::string touched_line(const rpc::Touched& touched) {
  std::string line = fmt::format("{} {}", touched.job, state_name(touched.state));
  if (!touched.words.empty()) line += ": " + terminal::shown_on_one_line(touched.words);
  return line;
}

std::string completion_line(const rpc::JobView& job) {
  std::string line = fmt::format("{}\t{}, {}", job.id, name_of_job(job), state_name(job.state));
  const std::string percent = percent_of(job);
  if (!percent.empty()) line += ", " + percent;
  return line;
}

}  // namespace sleight::cli
