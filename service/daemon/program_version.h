// Identifies the build of the installed programs. While the daemon runs, the programs may be
// replaced by a build of the same or of another results version. Thread safety: any thread.
#pragma once

#include <optional>
#include <string>

namespace sleight::daemon {

/// Returns a stamp that changes when the file is replaced or written. Empty: there is no file.
std::string stamp_of(const std::string& program);

/// Returns the version in the line "results ..." of `program --version`. None if the program can't
/// be run or doesn't print the line within k_version_s_max.
std::optional<std::string> results_version_of(const std::string& program);
inline constexpr double k_version_s_max = 10;

}  // namespace sleight::daemon
