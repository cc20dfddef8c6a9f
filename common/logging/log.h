// Logging: spdlog to stderr, since stdout is for results. Call once, first thing in a main.
#pragma once

#include <string_view>

namespace sleight::logging {

/// Sends spdlog's default logger to stderr under the program's name. `verbose` adds debug lines.
void log_to_stderr(std::string_view program, bool verbose);

}  // namespace sleight::logging
