// Logs with spdlog to stderr, because stdout is for results. Thread-safe except log_to_stderr,
// which main calls once at the start.
#pragma once

#include <string_view>

namespace sleight::logging {

/// Sends spdlog's default logger to stderr with the program's name. `verbose` adds debug lines.
void log_to_stderr(std::string_view program, bool verbose);

/// Log one line; the text is not interpreted as a format.
void info(std::string_view text);
void warn(std::string_view text);

}  // namespace sleight::logging
