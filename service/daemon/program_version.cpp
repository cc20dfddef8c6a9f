#include "service/daemon/program_version.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <string_view>

#include "common/base/error.h"
#include "service/keeper/command.h"
#include "service/keeper/tool.h"

namespace sleight::daemon {

std::string stamp_of(const std::string& program) {
  struct stat file {};
  if (::stat(program.c_str(), &file) != 0) return {};
  return fmt::format("{}:{}:{}:{}.{}", file.st_dev, file.st_ino, file.st_size, file.st_mtim.tv_sec,
                     file.st_mtim.tv_nsec);
}

std::optional<std::string> results_version_of(const std::string& program) {
  constexpr std::string_view k_before = "\nresults ";
  try {
    const keeper::ToolEnd end = keeper::run_tool(
        {program, "--version"},
        {.seconds_max = k_version_s_max, .environment = keeper::program_environment()});
    const std::size_t at = end.output.find(k_before);
    if (end.exit_code != 0 || at == std::string::npos) return std::nullopt;
    const std::size_t begin = at + k_before.size();
    return end.output.substr(begin, end.output.find('\n', begin) - begin);
  } catch (const base::Error&) {
    return std::nullopt;
  }
}

}  // namespace sleight::daemon
