#include "common/base/cores.h"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace sleight::base {
namespace {

namespace fs = std::filesystem;

/// Parses a quota such as "200000 100000": CPU time and period, in microseconds. "max 100000" and
/// version 1's -1 mean no quota.
std::optional<double> cores_of(std::istream& quota, std::istream& period) {
  double quota_us = 0;
  double period_us = 0;
  if (!(quota >> quota_us) || !(period >> period_us) || quota_us <= 0 || period_us <= 0)
    return std::nullopt;
  return quota_us / period_us;
}

std::optional<double> quota_of_group(const fs::path& group) {
  if (std::ifstream both(group / "cpu.max"); both) return cores_of(both, both);
  std::ifstream quota(group / "cpu.cfs_quota_us");
  std::ifstream period(group / "cpu.cfs_period_us");
  return cores_of(quota, period);
}

std::string text_of(const char* path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

}  // namespace

std::optional<std::uint32_t> core_quota(std::string_view groups, const std::string& root) {
  std::optional<double> least;
  std::istringstream lines{std::string(groups)};
  // Lines are "0::/a/b" in version 2, "4:cpu,cpuacct:/a/b" in version 1.
  for (std::string number, controllers, path; std::getline(lines, number, ':') &&
                                              std::getline(lines, controllers, ':') &&
                                              std::getline(lines, path);) {
    if (!controllers.empty() && fmt::format(",{},", controllers).find(",cpu,") == std::string::npos)
      continue;
    const fs::path top = fs::path(root) / controllers;
    // In a container, `root` itself is the folder of the process's group, although
    // /proc/self/cgroup gives a longer path.
    for (fs::path below = fs::path(path).relative_path();; below = below.parent_path()) {
      if (const auto quota = quota_of_group(top / below))
        least = std::min(least.value_or(*quota), *quota);
      if (below.empty()) break;
    }
  }
  if (!least) return std::nullopt;
  return static_cast<std::uint32_t>(std::max(1.0, std::ceil(std::min(*least, 1e6))));
}

std::uint32_t cores_here() {
  cpu_set_t set;
  CPU_ZERO(&set);
  const long allowed = ::sched_getaffinity(0, sizeof(set), &set) == 0
                           ? CPU_COUNT(&set)
                           : ::sysconf(_SC_NPROCESSORS_ONLN);
  const auto cores = static_cast<std::uint32_t>(std::max(allowed, 1L));
  return std::min(cores,
                  core_quota(text_of("/proc/self/cgroup"), "/sys/fs/cgroup").value_or(cores));
}

}  // namespace sleight::base
