// A disk that fails when it is told to: SQLite's file functions with a fault at a chosen call.
//
// While an object lives, databases that are opened write through it. Counts writes, truncations
// and syncs of all files, in all threads; reads never fail.
#pragma once

#include <cstdint>

namespace sleight::store::testing {

class FaultyDisk {
 public:
  FaultyDisk();
  ~FaultyDisk();
  FaultyDisk(const FaultyDisk&) = delete;
  FaultyDisk& operator=(const FaultyDisk&) = delete;

  /// From now on, after `calls` good calls every call fails with SQLite's `code`.
  void fail_after(std::uint64_t calls, int code);
  /// The disk works again.
  void repair();
  /// Calls that failed since fail_after.
  std::uint64_t failures() const;
};

}  // namespace sleight::store::testing
