// Which build of the programs lies on the disk: they may be replaced while the daemon runs, by a
// later build that goes on with every run, or by one of another results version.
//
// Thread safety: any thread.
#pragma once

#include <optional>
#include <string>

namespace sleight::daemon {

/// Changes when the file is replaced or written; empty where there is none.
std::string stamp_of(const std::string& program);

/// What `program --version` says in its line "results ...". None where it can't be run, or says no
/// such thing within k_version_s_max.
std::optional<std::string> results_version_of(const std::string& program);
inline constexpr double k_version_s_max = 10;

}  // namespace sleight::daemon
