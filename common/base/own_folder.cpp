#include "common/base/own_folder.h"

#include <cstdlib>

namespace sleight::base {

std::optional<std::filesystem::path> own_folder(const char* variable, const char* below_home,
                                                const std::string& name) {
  const char* given = std::getenv(variable);
  if (given != nullptr && given[0] == '/') return std::filesystem::path(given) / "sleight" / name;
  const char* home = std::getenv("HOME");
  if (home != nullptr && home[0] == '/')
    return std::filesystem::path(home) / below_home / "sleight" / name;
  return std::nullopt;
}

}  // namespace sleight::base
