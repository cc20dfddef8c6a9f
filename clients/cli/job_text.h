// Jobs in words: a table of many, all of one, and single lines of what happened.
//
// All text of the service is made fit for a terminal here. Times are those of the local time zone.
//
// Pure but for the time zone; thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "clients/report/report.h"
#include "common/rpc/service.h"

namespace sleight::cli {

/// How a table of jobs looks.
struct TableLook {
  std::optional<std::size_t> width{};  ///< of the terminal; none: nothing is cut
  bool with_users = false;
  /// The name of a uid.
  std::function<std::string(std::uint32_t)> user_name{};
};

/// One line a job, after the heads: place in the queue and why not yet, time left by scans and by
/// solutions, finds and solutions in proportion apart, failures by kind.
std::string job_table(std::span<const rpc::JobView> jobs, const TableLook& look);

/// All of a job but its history.
report::Report job_report(const rpc::JobView& job);
/// The same over several lines.
std::string job_text(const rpc::JobView& job);

/// Its changes, one a line: when, state, attempt, reason.
std::string history_text(const rpc::JobView& job);

/// "17 done: 5 found, 12 in proportion, 40,000 scans; 12:30 of processor time": how a job ended,
/// or, of one that has not, how it stands.
std::string end_line(const rpc::JobView& job);

/// "17 cancelled: stops at the next scan".
std::string touched_line(const rpc::Touched& touched);

/// "17\tHI, running, 31%": for shell completion.
std::string completion_line(const rpc::JobView& job);

/// "hi" of a job without another name.
std::string name_of_job(const rpc::JobView& job);

/// "2 found", "2 of 5 found, 3 of 50 in proportion"; empty where there are none and none are asked
/// for.
std::string solutions_text(const rpc::SolutionCounts& counts);

/// "search_gave_up 2, work_limit 1".
std::string failures_text(std::span<const rpc::FailureCount> failures);

/// "812 B", "12.3 MB", "24 GB": three digits.
std::string size_text(std::uint64_t bytes);

/// "2026-11-26 05:12:40"; "-" of 0.
std::string local_time(double time_s);

}  // namespace sleight::cli
