// Whether a path lies on a disk that other machines see too. There SQLite's shared memory and flock
// hold on one machine alone, or not at all.
//
// The environment may know better: SLEIGHT_NETWORK_DISK=1 says that every disk is one (for a disk
// that we don't know, and for tests), 0 that none is (for a FUSE disk of this machine alone). All
// programs that write one folder must be told the same.
//
// Thread-safe.
#pragma once

#include <optional>
#include <string>

namespace sleight::base {

inline constexpr const char* k_network_disk_variable = "SLEIGHT_NETWORK_DISK";

/// The network file system on which a file or folder lies: "NFS", "SMB", "Lustre", "GPFS", "Ceph"
/// or "FUSE", which may stand for any; k_network_disk_variable where that alone says so. None for
/// local disks, and where there is no such path.
std::optional<std::string> network_file_system(const std::string& path);

}  // namespace sleight::base
