// The record of a run session's end, stored in the run store and read by supervisors.
//
// A session is one start of a run's program. Before the session exits, it writes its record to the
// run store. If a supervisor requested it, the session also writes the record as one line to a pipe
// (clients/cli/end_report.h). The pipe is needed because the store has no record if the disk is
// full or the session was refused. If there is no record at all, the session was killed or crashed.
//
// The line is a JSON object and a newline. The object has all fields below, by name. The field
// `end` is written as a name (name_of), and `exit_code` as a number. The line has at most
// k_end_line_bytes_max bytes, so that a pipe accepts it at once; longer messages lose their middle.
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

/// Bytes that a pipe accepts atomically (PIPE_BUF of Linux).
inline constexpr std::size_t k_end_line_bytes_max = 4096;

enum class End {
  finished,           ///< the request's goal is reached
  gave_up,            ///< a search found less than requested; a rerun would too
  no_draws,           ///< all scans ended within burn-in; a rerun would too
  time_limit,         ///< stopped cleanly by its --time-limit
  stop_requested,     ///< stopped cleanly by a signal
  simulation_failed,  ///< --strict, and a simulation failed
  failed,             ///< an error: `exit_code` is its kind, `words` its message
  bug                 ///< a check failed at `place`
};

struct RunEnd {
  std::uint64_t epoch = 0;  ///< of the session; 0: it ended before opening the run store
  End end = End::finished;
  base::ExitCode exit_code = base::ExitCode::ok;  ///< of the run; `bug` for a bug
  std::uint64_t scans = 0;                        ///< of every chain in the archive
  std::uint64_t found = 0;                        ///< finds in the archive
  std::uint64_t solutions = 0;                    ///< independent, all sessions
  std::string digest{};                           ///< of the archive; empty: none written
  std::string words{};                            ///< for people: the error, or what is missing
  std::string place{};                            ///< of a failed check: "file.cpp:12"

  bool operator==(const RunEnd&) const = default;
};

std::string_view name_of(End end);

/// Returns the record of a session that an exception ended. A base::Error gives its kind and
/// message; any other exception is a bug.
RunEnd end_by(const std::exception& error);

std::string to_line(const RunEnd& end);

/// Parses a line that to_line wrote, with or without its newline. Returns nothing for other text.
std::optional<RunEnd> run_end_of(std::string_view line);

}  // namespace sleight::events
