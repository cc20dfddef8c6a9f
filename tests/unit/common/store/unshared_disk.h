// A disk that machines share, as SQLite sees one: without shared memory. While an object lives,
// databases that are opened lie on such a disk, and every disk is taken for a network disk.
//
// A process can be made to stand still in the middle of a commit, as on a machine that sleeps.
#pragma once

#include <cstdint>

namespace sleight::store::testing {

class UnsharedDisk {
 public:
  UnsharedDisk();
  ~UnsharedDisk();
  UnsharedDisk(const UnsharedDisk&) = delete;
  UnsharedDisk& operator=(const UnsharedDisk&) = delete;

  /// After so many more writes and syncs of files this process stops itself (SIGSTOP), once.
  void stop_after(std::uint64_t calls);
};

}  // namespace sleight::store::testing
