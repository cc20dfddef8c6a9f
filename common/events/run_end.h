// How a session of a run ended: one record, which the run store keeps and supervisors read.
//
// A session is one start of a run's program. It leaves its record in the run store before it ends,
// and, where a supervisor asked for it, as one line in a pipe (clients/cli/end_report.h): a full
// disk or a refusal leaves nothing in the store. A session without a record died.
//
// The line is a JSON object with all fields below by their names, `end` by name_of and `exit_code`
// as a number, and ends with a newline. It is at most k_end_line_bytes_max long, so that a pipe
// takes it whole; longer words lose their middle.
//
// Thread safety: values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/error.h"

namespace sleight::events {

/// A pipe takes so much at once, or nothing (PIPE_BUF of Linux).
inline constexpr std::size_t k_end_line_bytes_max = 4096;

enum class End {
  finished,           ///< what the request asks for is there
  gave_up,            ///< a search that found less than was asked for: another would end so too
  no_draws,           ///< all scans are made, and the burn-in had not ended: likewise
  time_limit,         ///< stopped in order by its --time-limit
  stop_requested,     ///< stopped in order by a signal
  simulation_failed,  ///< --strict, and a simulation failed
  failed,             ///< an error, of which `exit_code` is the kind and `words` what it says
  bug                 ///< a check of ours failed at `place`
};

struct RunEnd {
  std::uint64_t epoch = 0;  ///< of the session; 0: it ended before it had the run store
  End end = End::finished;
  base::ExitCode exit_code = base::ExitCode::ok;  ///< of the run so ended; of a bug, `bug`
  std::uint64_t scans = 0;                        ///< that every chain has in the archive
  std::uint64_t found = 0;                        ///< by a search, in the archive
  std::uint64_t solutions = 0;                    ///< independent ones, earlier sessions included
  std::string digest{};                           ///< of the archive; empty: the session wrote none
  std::string words{};                            ///< for people: the error, or what is missing
  std::string place{};                            ///< of a failed check: "file.cpp:12"

  bool operator==(const RunEnd&) const = default;
};

/// "finished", "time_limit" and so on, as in the enumeration.
std::string_view name_of(End end);

/// Of a session that an exception ended: base::Error's kind and words; any other is a bug of ours.
RunEnd end_by(const std::exception& error);

/// The record as a line.
std::string to_line(const RunEnd& end);

/// None for anything that to_line did not write, with or without its newline.
std::optional<RunEnd> run_end_of(std::string_view line);

}  // namespace sleight::events
