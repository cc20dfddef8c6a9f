// Detects disks shared with other machines. On shared disks, SQLite's shared memory and flock work
// only within one machine, or not at all.
//
// The environment can override the detection. With SLEIGHT_NETWORK_DISK=1 every disk counts as a
// network disk (for unknown disks, and for tests). With SLEIGHT_NETWORK_DISK=0 every disk counts as
// local (for a FUSE disk that only this machine uses). All programs that write a folder must use
// the same setting.
//
// Thread-safe.
#pragma once

#include <optional>
#include <string>

namespace sleight::base {

inline constexpr const char* k_network_disk_variable = "SLEIGHT_NETWORK_DISK";

/// Returns the name of a path's network file system, such as "NFS", "SMB", "Lustre", "GPFS" or
/// "Ceph". Returns "FUSE" for any FUSE file system, and k_network_disk_variable if only the
/// variable makes the disk a network disk. Returns nothing for local disks and missing paths.
std::optional<std::string> network_file_system(const std::string& path);

}  // namespace sleight::base
