// The lock of a job's folder, which its keeper holds for life.
//
// Invariants:
//   1. At most one holds it, and it goes with the process, however that ends.
//   2. Looking takes nothing: a look never makes a keeper that just begins fail.
//
// A process that was forked from the holder holds it too until it execs.
//
// Thread safety: a KeeperLock belongs to one thread; is_held any.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sleight::keeper {

class KeeperLock {
 public:
  /// None: another has it. Throws base::Error where the folder can't be written, or its file system
  /// has no locks.
  static std::optional<KeeperLock> take(const std::string& folder);
  ~KeeperLock();
  KeeperLock(KeeperLock&& other) noexcept;
  KeeperLock& operator=(KeeperLock&&) = delete;
  KeeperLock(const KeeperLock&) = delete;
  KeeperLock& operator=(const KeeperLock&) = delete;

  /// For disks whose locks outlive a lost machine, or that have none: marks the attempt as begun,
  /// for ever and on all machines (`begun.N`; older marks go). False: it had begun. Throws
  /// base::Error.
  static bool mark_begun(const std::string& folder, std::uint32_t attempt);
  /// Whether it was so marked.
  static bool has_begun(const std::string& folder, std::uint32_t attempt);

  /// Whether a keeper holds it. False where there is no folder.
  static bool is_held(const std::string& folder);

 private:
  explicit KeeperLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;
};

}  // namespace sleight::keeper
