#include "service/keeper/process_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace sleight::keeper {
namespace {

struct Stat {
  char state = '?';
  pid_t parent = 0;
  std::uint64_t start_ticks = 0;
};

/// Returns an empty text if the file doesn't exist or its process has ended.
std::string content_of(const std::string& path) {
  // If the process ends while its file is read, reading fails. `<<` treats this as the file's end.
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return std::move(text).str();
}

/// Parses /proc/PID/stat (proc(5)). The name is in brackets and may contain any character.
std::optional<Stat> stat_of(pid_t pid) {
  const std::string text = content_of(fmt::format("/proc/{}/stat", pid));
  const std::size_t bracket = text.rfind(')');
  if (bracket == std::string::npos) return std::nullopt;
  std::istringstream fields(text.substr(bracket + 1));
  Stat stat;
  fields >> stat.state >> stat.parent;
  // Skip to field 22; the parent is field 4.
  std::string skipped;
  for (int field = 5; field < 22; ++field)
    fields >> skipped;
  fields >> stat.start_ticks;
  if (!fields) return std::nullopt;
  return stat;
}

std::optional<pid_t> number_in(std::string_view name) {
  pid_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc() || end != name.data() + name.size()) return std::nullopt;
  return number;
}

/// Returns the numeric entries of a folder in /proc.
std::vector<pid_t> numbers_in(const std::string& folder) {
  std::vector<pid_t> numbers;
  std::error_code error;
  for (std::filesystem::directory_iterator i(folder, error), end; !error && i != end;
       i.increment(error)) {
    if (const auto number = number_in(i->path().filename().string())) numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

bool is_living(const ProcessIdentity& identity) {
  const auto stat = stat_of(identity.pid);
  return stat && stat->state != 'Z' && stat->state != 'X' && identity_of(identity.pid) == identity;
}

std::optional<ProcessIdentity> identity_of(pid_t pid) {
  const auto stat = stat_of(pid);
  if (!stat) return std::nullopt;
  std::string boot = content_of("/proc/sys/kernel/random/boot_id");
  while (!boot.empty() && boot.back() == '\n')
    boot.pop_back();
  return ProcessIdentity{.pid = pid, .start_ticks = stat->start_ticks, .boot = std::move(boot)};
}

std::vector<pid_t> children_of(pid_t pid) {
  std::vector<pid_t> children;
  // Each thread of the process has its own list of children.
  for (const pid_t thread : numbers_in(fmt::format("/proc/{}/task", pid))) {
    std::ifstream list(fmt::format("/proc/{}/task/{}/children", pid, thread));
    if (!list) {
      const bool has_gone =
          !std::filesystem::exists(fmt::format("/proc/{}/task/{}/stat", pid, thread));
      if (has_gone) continue;
      return children_by_search(pid);
    }
    children.insert(children.end(), std::istream_iterator<pid_t>(list), {});
  }
  std::sort(children.begin(), children.end());
  return children;
}

std::vector<pid_t> children_by_search(pid_t pid) {
  std::vector<pid_t> children;
  for (const pid_t other : numbers_in("/proc")) {
    const auto stat = stat_of(other);
    if (stat && stat->parent == pid) children.push_back(other);
  }
  std::sort(children.begin(), children.end());
  return children;
}

bool has_living_child(pid_t pid) {
  const std::vector<pid_t> children = children_of(pid);
  return std::any_of(children.begin(), children.end(), [](pid_t child) {
    const auto stat = stat_of(child);
    return stat && stat->state != 'Z' && stat->state != 'X';
  });
}

}  // namespace sleight::keeper
