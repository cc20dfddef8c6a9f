// The number of threads that this process may keep busy.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::base {

/// Returns the cores in this process's affinity (taskset, Slurm), limited by the CPU quota of its
/// control groups (containers, systemd), rounded up. At least 1.
std::uint32_t cores_here();

/// Returns the smallest quota of the control groups and their parents, in cores rounded up; nothing
/// if there is no quota. `groups`: text of /proc/self/cgroup, version 1 or 2. `root`: folder of the
/// kernel's control-group files, /sys/fs/cgroup.
std::optional<std::uint32_t> core_quota(std::string_view groups, const std::string& root);

}  // namespace sleight::base
