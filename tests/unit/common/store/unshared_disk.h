// A disk that machines share, and on which SQLite has no shared memory. While an UnsharedDisk
// exists, databases are opened on it, and every disk counts as a network disk.
//
// A process can pause within a commit, as on a suspended machine.
#pragma once

#include <cstdint>

namespace sleight::store::testing {

class UnsharedDisk {
 public:
  UnsharedDisk();
  ~UnsharedDisk();
  UnsharedDisk(const UnsharedDisk&) = delete;
  UnsharedDisk& operator=(const UnsharedDisk&) = delete;

  /// Stops this process (SIGSTOP) once, after `calls` more writes and syncs of files.
  void stop_after(std::uint64_t calls);
};

}  // namespace sleight::store::testing
