// Whether a path lies on a disk that other machines see too. There SQLite's shared memory and flock
// hold on one machine alone, or not at all.
//
// Thread-safe.
#pragma once

#include <optional>
#include <string>

namespace sleight::base {

/// The network file system on which a file or folder lies: "NFS", "SMB", "Lustre", "GPFS", "Ceph"
/// or "FUSE", which may stand for any. None for local disks, and where there is no such path.
std::optional<std::string> network_file_system(const std::string& path);

/// The name that belongs to the type that statfs gives, or none.
std::optional<std::string> network_file_system_of_type(unsigned long type);

}  // namespace sleight::base
