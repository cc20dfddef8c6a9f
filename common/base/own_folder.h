// Where a person's files of one kind are, by the XDG base directory specification.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace sleight::base {

/// $`variable`/sleight/`name`, or ~/`below_home`/sleight/`name` where the variable is not set or no
/// absolute path; none without a home. Nothing is made.
std::optional<std::filesystem::path> own_folder(const char* variable, const char* below_home,
                                                const std::string& name);

}  // namespace sleight::base
