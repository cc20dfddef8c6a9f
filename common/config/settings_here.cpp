// Reads this process's environment, machine and file for settings.h.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/base/cores.h"
#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/config/settings.h"

namespace sleight::config {
namespace {

constexpr std::size_t k_file_bytes_max = std::size_t{64} << 10U;

/// Returns nothing if the file does not exist. An unreadable file is an error, because it may
/// contain limits.
std::optional<ConfigFile> file_here(const Surroundings& surroundings) {
  const auto path = config_path_of(surroundings);
  std::error_code none;
  if (!path || !std::filesystem::exists(std::filesystem::symlink_status(*path, none)))
    return std::nullopt;
  return ConfigFile{*path, base::read_text_file(*path, k_file_bytes_max)};
}

}  // namespace

Surroundings surroundings_here() {
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long page_bytes = ::sysconf(_SC_PAGESIZE);
  return {.variable = [](std::string_view name) -> std::optional<std::string> {
            const char* text = std::getenv(std::string(name).c_str());
            return text == nullptr ? std::nullopt : std::optional<std::string>(text);
          },
          .cores = base::cores_here(),
          .memory_bytes = static_cast<std::uint64_t>(std::max(pages, 0L)) *
                          static_cast<std::uint64_t>(std::max(page_bytes, 0L))};
}

ToCall service_to_call() {
  const Settings settings = settings_here();
  if (!settings.server.value.empty()) return {.server = settings.server.value};
  const bool is_set =
      settings.socket.origin != Origin::fallback || settings.state.origin != Origin::fallback;
  std::error_code none;
  const auto is_there = [&](const std::string& path) {
    return std::filesystem::is_socket(path, none);
  };
  const std::string machine(k_machine_socket);
  if (is_set || is_there(settings.socket.value) || !is_there(machine))
    return {.socket = settings.socket.value};
  return {.socket = machine};
}

Settings settings_here(const std::vector<Given>& command_line) {
  const Surroundings surroundings = surroundings_here();
  auto settings = settings_of(surroundings, file_here(surroundings), command_line);
  if (settings) return std::move(settings).value();
  std::string lines = "the settings have errors";
  for (const request::Diagnostic& error : settings.error())
    lines += "\n  " + request::to_string(error);
  throw base::Error(base::ExitCode::usage, lines);
}

}  // namespace sleight::config
