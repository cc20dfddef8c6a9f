// The number of threads that this process may keep busy.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::base {

/// Returns the number of cores in this process's affinity (taskset, Slurm). If the control groups'
/// CPU quota (containers, systemd) is lower, returns that quota, rounded up. At least 1.
std::uint32_t cores_here();

/// Returns the smallest quota of the control groups and their parents, in cores, rounded up.
/// Returns nothing if there is no quota. `groups`: text of /proc/self/cgroup, version 1 or 2.
/// `root`: folder of the kernel's control-group files, /sys/fs/cgroup.
std::optional<std::uint32_t> core_quota(std::string_view groups, const std::string& root);

}  // namespace sleight::base
