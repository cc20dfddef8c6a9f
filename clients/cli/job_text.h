// Formats jobs for people: a table of jobs, a report of one job, and lines about events.
//
// All text from the service is made safe for a terminal here. Times are in the local time zone.
// Pure functions, except that they read the time zone; thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "clients/report/report.h"
#include "common/rpc/service.h"

namespace sleight::cli {

struct TableLook {
  std::optional<std::size_t> width{};  ///< of the terminal; none: nothing is cut
  bool with_users = false;
  std::function<std::string(std::uint32_t)> user_name{};
};

/// Returns a table with a heading and one line per job.
std::string job_table(std::span<const rpc::JobView> jobs, const TableLook& look);

/// Reports everything about a job except its history.
report::Report job_report(const rpc::JobView& job);
std::string job_text(const rpc::JobView& job);

/// Returns a line for each change. A line has the time, the state, the attempt and the reason.
std::string history_text(const rpc::JobView& job);

/// Returns, for example, "17 done: 5 found, 12 in proportion, 40,000 scans; 12:30 of processor
/// time". For unfinished jobs, returns the current status.
std::string end_line(const rpc::JobView& job);

/// Returns, for example, "17 cancelled: stops at the next scan".
std::string touched_line(const rpc::Touched& touched);

/// Returns a line for shell completion, such as "17\tHI, running, 31%".
std::string completion_line(const rpc::JobView& job);

/// Returns the job's name, or its world's name if the job has none.
std::string name_of_job(const rpc::JobView& job);

/// Returns, for example, "2 of 5 found, 3 of 50 in proportion". Empty if no solutions exist and
/// none were requested.
std::string solutions_text(const rpc::SolutionCounts& counts);

/// Returns, for example, "search_gave_up 2, work_limit 1".
std::string failures_text(std::span<const rpc::FailureCount> failures);

/// Returns three digits, such as "812 B", "12.3 MB" or "24 GB".
std::string size_text(std::uint64_t bytes);

/// Returns, for example, "2026-11-26 05:12:40"; "-" for 0.
std::string local_time(double time_s);

}  // namespace sleight::cli
