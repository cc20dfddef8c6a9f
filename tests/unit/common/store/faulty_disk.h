// Makes chosen calls of SQLite's file functions fail.
//
// If a database is opened while a FaultyDisk exists, it uses the FaultyDisk. The FaultyDisk counts
// writes, truncations and syncs of all files in all threads. Reads never fail.
#pragma once

#include <cstdint>
#include <limits>

namespace sleight::store::testing {

class FaultyDisk {
 public:
  static constexpr std::uint64_t k_for_ever = std::numeric_limits<std::uint64_t>::max();

  FaultyDisk();
  ~FaultyDisk();
  FaultyDisk(const FaultyDisk&) = delete;
  FaultyDisk& operator=(const FaultyDisk&) = delete;

  /// After `calls` more successful calls, makes `times` calls fail with SQLite's `code`.
  void fail_after(std::uint64_t calls, int code, std::uint64_t times = k_for_ever);
  void repair();
  std::uint64_t failures() const;
};

}  // namespace sleight::store::testing
