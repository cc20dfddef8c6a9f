// Logging: spdlog to stderr, since stdout is for results. Thread-safe but for log_to_stderr, which
// a main calls once, first thing.
#pragma once

#include <string_view>

namespace sleight::logging {

/// Sends spdlog's default logger to stderr under the program's name. `verbose` adds debug lines.
void log_to_stderr(std::string_view program, bool verbose);

/// One line each; the text stands as it is.
void info(std::string_view text);
void warn(std::string_view text);

}  // namespace sleight::logging
