// One process writes a run: the lock in its folder.
//
// On a local disk it is flock on the file `lock`, which the kernel frees however the process ends.
// On a network disk (base/network_disk.h) it is a lease (lease.h). A lease may end while the
// process lives, because the disk or the process stood still for too long. Then another may have
// the run, and this one must not write: `check` comes before and after every commit. A folder that
// has a lease's file is locked by a lease whatever its disk is, so that two opinions of one disk
// end in one kind of lock.
//
// Thread safety: check from any thread, set_epoch from one; the rest belongs to the owner.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/store/lease.h"

namespace sleight::store {

struct RunLockOptions {
  /// Asked while it waits for a dead holder's lease to end; base::Error(interrupted) if true.
  std::function<bool()> stop_requested{};
  /// False: the lease of a holder on another machine is taken for good, alive or not.
  bool waits = true;
  double lease_s = k_lease_s;
  std::optional<LeaseHolder> self{};  ///< for tests: this process as another machine's
};

class RunLock {
 public:
  /// Makes the folder if need be. Throws base::Error(conflict), naming the other process, when it
  /// is taken. On a network disk that takes as long as a renewal where the holder is alive on
  /// another machine, and a whole lease where it died there.
  explicit RunLock(const std::string& folder, RunLockOptions options = {});
  /// Lets go. REQUIRES: nothing is written any more.
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

  /// Begins to renew the lease, in a thread; until then the process may fork safely, and must come
  /// here within the lease or call renew. Nothing on a local disk, or if it does so already.
  void keep();
  /// Renews the lease now if that is due; for those who are long about something before keep.
  void renew();
  /// Throws base::Error(conflict) where the run may be another's by now.
  void check() const;
  /// For people who are refused: the session's number.
  void set_epoch(std::uint64_t epoch);
  /// Whether a process on another machine had the lock and never let go: a file that it has open,
  /// it may still write, whatever the lock says. Such files are replaced (take_over.h).
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
