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

/// Returns the name of the network file system that contains the path, such as "NFS", "SMB",
/// "Lustre", "GPFS" or "Ceph". For any FUSE file system, returns "FUSE". If the disk counts as a
/// network disk only because of the variable, returns k_network_disk_variable. Returns nothing for
/// local disks and missing paths.
std::optional<std::string> network_file_system(const std::string& path);

}  // namespace sleight::base
