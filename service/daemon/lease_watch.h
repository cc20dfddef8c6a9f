// Whether somebody on another machine may still write a run: its lease (common/store/lease.h),
// looked at from outside. Nothing is taken, so that whoever really wants the run isn't kept from
// it.
//
// Not thread-safe.
#pragma once

#include <cstdint>
#include <string>

namespace sleight::daemon {

class LeaseWatch {
 public:
  /// `run_folder`: of the run store; it may be missing.
  explicit LeaseWatch(std::string run_folder) : run_folder_(std::move(run_folder)) {}

  /// False: there is none, its holder let go, is known to be dead, or hasn't renewed it for a whole
  /// lease of looks. True too where the disk doesn't say.
  bool may_live(double now_s);

 private:
  std::string run_folder_;
  std::uint64_t generation_ = 0;
  std::string text_{};
  double since_s_ = 0;  ///< when it was seen like this first
};

}  // namespace sleight::daemon
