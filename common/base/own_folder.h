// Finds the folders of a user's files by the XDG base directory specification.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace sleight::base {

/// Returns $`variable`/sleight/`name`, or ~/`below_home`/sleight/`name` if the variable is unset or
/// not an absolute path; nothing without a home. Creates nothing.
std::optional<std::filesystem::path> own_folder(const char* variable, const char* below_home,
                                                const std::string& name);

}  // namespace sleight::base
