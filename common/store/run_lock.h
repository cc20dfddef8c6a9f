// The lock in a run's folder, which lets only one process write the run.
//
// On a local disk the lock is flock on the file `lock`, which the kernel releases however the
// process ends. On a network disk (base/network_disk.h) it is a lease (lease.h). A lease may end
// during the process's life, because the disk or the process stalled for too long. Then another
// process may have the run, and this process must not write. So `check` is called before and after
// every commit. A folder with a lease file is always locked by a lease, so that processes that
// disagree about the disk use the same lock.
//
// Thread safety: `check` may be called from any thread, and `set_epoch` from one thread. The owner
// calls all other functions.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/store/lease.h"

namespace sleight::store {

struct RunLockOptions {
  /// The lock polls this function while it waits for a dead holder's lease to end. If true, throws
  /// base::Error(interrupted).
  std::function<bool()> stop_requested{};
  /// False: don't wait, and treat the lease of a holder on another machine as held, whether the
  /// holder is alive or dead.
  bool waits = true;
  double lease_s = k_lease_s;
  std::optional<LeaseHolder> self{};  ///< for tests: this process as on another machine
};

class RunLock {
 public:
  /// Locks the folder, creating it if missing. Throws base::Error(conflict) naming the holder if
  /// the lock is held. On a network disk, this takes the time of one renewal if the holder is alive
  /// on another machine, and the time of a whole lease if the holder died there.
  explicit RunLock(const std::string& folder, RunLockOptions options = {});
  /// Releases the lock. REQUIRES: this process no longer writes the run.
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

  /// Starts a thread that renews the lease. Before this call, the process may fork safely. Call
  /// `keep` or `renew` before the lease ends. `keep` has no effect on a local disk, or if the
  /// thread runs already.
  void keep();
  /// Renews the lease now if a renewal is due. For long work before keep.
  void renew();
  /// Throws base::Error(conflict) if another process may have the run now.
  void check() const;
  /// Sets the session's number, which processes that are refused will report.
  void set_epoch(std::uint64_t epoch);
  /// Returns whether a holder on another machine never released the lock. Even without the lock,
  /// that holder may still write its open files, so these files must be replaced (take_over.h).
  bool owes_copies() const;
  void set_copied();

 private:
  struct Leased;
  void flock_it();

  std::string folder_;
  int descriptor_ = -1;             ///< on a local disk
  std::unique_ptr<Leased> leased_;  ///< on a network disk
};

}  // namespace sleight::store
