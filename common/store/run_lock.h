// The lock in a run's folder. Only the process that has the lock may write the run.
//
// On a local disk the lock is flock on the file `lock`. The kernel releases a flock however the
// process ends. On a network disk (base/network_disk.h) the lock is a lease (lease.h). A lease may
// end during the process's life, because the disk or the process stalled for too long. After the
// lease's end, another process may have the run, and this process must not write. So `check` is
// called before and after every commit. If a folder has a lease file, it is always locked by a
// lease. So two processes use the same lock even if only one considers the disk a network disk.
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
  /// False: don't wait. A lease of a holder on another machine then counts as held, even if the
  /// holder is dead.
  bool waits = true;
  double lease_s = k_lease_s;
  std::optional<LeaseHolder> self{};  ///< for tests: this process as on another machine
};

class RunLock {
 public:
  /// Creates the folder if it is missing, and locks it. If the lock is held, throws
  /// base::Error(conflict) that names the holder. On a network disk this takes time if the holder
  /// is on another machine: the time of one renewal if the holder is alive, and of a whole lease if
  /// it is dead.
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
  /// Sets the session's number. A process that is refused the lock reports this number.
  void set_epoch(std::uint64_t epoch);
  /// Returns whether a holder on another machine never released the lock. Such a holder may still
  /// write its open files, even without the lock. So the files must be replaced (take_over.h).
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
