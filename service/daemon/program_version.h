// Identifies the build of the installed programs. While the daemon runs, another build may replace
// them, even one with another results version. Thread safety: any thread.
#pragma once

#include <optional>
#include <string>

namespace sleight::daemon {

/// Returns a stamp of the file. The stamp changes when the file is replaced or written. Empty:
/// there is no file.
std::string stamp_of(const std::string& program);

/// Returns the version in the line "results ..." of `program --version`. None: the program can't be
/// run, or it doesn't print the line within k_version_s_max.
std::optional<std::string> results_version_of(const std::string& program);
inline constexpr double k_version_s_max = 10;

}  // namespace sleight::daemon
