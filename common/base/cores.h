// How many threads this process may keep busy.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::base {

/// Cores that this process may use: those of its affinity (taskset, Slurm), but no more than the
/// CPU quota of its control groups (containers, systemd) pays for, rounded up. At least 1.
std::uint32_t cores_here();

/// The least quota of these groups and those above them, in cores rounded up; none where there is
/// none. `groups`: as /proc/self/cgroup has them, of version 1 or 2; `root`: where the kernel's
/// files of groups lie, /sys/fs/cgroup.
std::optional<std::uint32_t> core_quota(std::string_view groups, const std::string& root);

}  // namespace sleight::base
