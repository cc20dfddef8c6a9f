// The lock of a job's folder. The folder's keeper holds the lock as long as the keeper runs.
//
// Invariants:
//   1. At most one process holds the lock. When that process ends, the lock is released.
//   2. Testing the lock doesn't take it, so a test never makes a starting keeper fail.
//
// If the holder forks a process, that process also holds the lock until it calls exec.
//
// Thread safety: a KeeperLock belongs to one thread; is_held() may be called from any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sleight::keeper {

class KeeperLock {
 public:
  /// None: another process has the lock. Throws base::Error if the folder can't be written or its
  /// file system has no locks.
  static std::optional<KeeperLock> take(const std::string& folder);
  ~KeeperLock();
  KeeperLock(KeeperLock&& other) noexcept;
  KeeperLock& operator=(KeeperLock&&) = delete;
  KeeperLock(const KeeperLock&) = delete;
  KeeperLock& operator=(const KeeperLock&) = delete;

  /// Marks the attempt as begun for all machines (`begun.N`), and removes older marks. The mark is
  /// needed on a disk that has no locks, or has locks that outlive a lost machine. False: already
  /// marked. Throws base::Error.
  static bool mark_begun(const std::string& folder, std::uint32_t attempt);
  /// Returns whether mark_begun() has marked the attempt.
  static bool has_begun(const std::string& folder, std::uint32_t attempt);

  /// Returns whether a keeper holds the lock. False: no keeper holds it, or the folder doesn't
  /// exist.
  static bool is_held(const std::string& folder);

 private:
  explicit KeeperLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;
};

}  // namespace sleight::keeper
