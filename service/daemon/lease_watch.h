// Watches a run lease (common/store/lease.h). The watch shows whether a process on another machine
// can still write the run. The watch takes no lease, so it blocks no other process. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <string>

namespace sleight::daemon {

class LeaseWatch {
 public:
  /// `run_folder`: the run store's folder, which may be missing.
  explicit LeaseWatch(std::string run_folder) : run_folder_(std::move(run_folder)) {}

  /// Returns false if no lease exists, if its holder released it or is known to be dead, or if no
  /// call has seen a renewal for the length of a lease. If the disk can't be read, returns true.
  bool may_live(double now_s);

 private:
  std::string run_folder_;
  std::uint64_t generation_ = 0;
  std::string text_{};
  double since_s_ = 0;  ///< first time that the lease was seen in this state
};

}  // namespace sleight::daemon
