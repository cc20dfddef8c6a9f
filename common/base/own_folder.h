// Finds the folders of a user's files by the XDG base directory specification.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace sleight::base {

/// Returns $`variable`/sleight/`name`. If the variable is unset or not an absolute path, returns
/// ~/`below_home`/sleight/`name`. If there is no home either, returns nothing. Creates nothing.
std::optional<std::filesystem::path> own_folder(const char* variable, const char* below_home,
                                                const std::string& name);

}  // namespace sleight::base
