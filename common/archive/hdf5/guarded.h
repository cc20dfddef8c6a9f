// Reading of files that are not ours, in a child process that may crash, hang or eat memory.
//
// HDF5 1.10.8 has known faults that a damaged or hostile file can reach from H5Fopen on, and can
// spin for minutes on a few flipped bits. The checks of reader.h come after H5Fopen, so they alone
// are not enough: programs open archives inside `guarded`.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace sleight::archive::hdf5 {

struct GuardLimits {
  /// The child's whole address space. Not enforced under the address or thread sanitizer, whose
  /// own maps need more than any limit.
  std::uint64_t address_space_bytes = std::uint64_t{4} << 30;
  std::uint32_t cpu_s = 600;  ///< processor time
  double timeout_s = 900;     ///< time on the wall
};

/// Runs `work` in a forked child, with our stdout and stderr, and returns what it returns (an exit
/// code, 0 to 255). Nothing else comes back: what `work` changes in memory is lost.
///
/// Throws what `work` throws, as a base::Error with its exit code and message; a base::Error with
/// ExitCode::bad_archive naming `subject` (the archive's path) when the child crashes, exceeds a
/// limit or runs out of memory; with ExitCode::interrupted when the child is ended by Ctrl-C or
/// SIGTERM. Returns 141 when the reader of our stdout went away. REQUIRES: no other thread runs: a
/// fork copies one thread, and another may hold a lock that `work` needs. The C library's allocator
/// is safe there, a sanitizer's is not, and its child would wait for ever.
int guarded(const std::string& subject, const GuardLimits& limits,
            const std::function<int()>& work);

}  // namespace sleight::archive::hdf5
