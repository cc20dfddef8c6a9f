// A checkpoint is an archive of the run so far, for people who watch the run.
//
// A separate thread derives checkpoints, so that the run never waits for them. The first checkpoint
// is made as soon as a search has its finds, or at the first solution. Later checkpoints are made
// at intervals of at least `every_s`. If checkpoints would take more than k_checkpoint_share_max of
// the workers' time, intervals are longer. The simulation of kept animations' motions doesn't
// count, because each motion is simulated once for all archives.
//
// The thread runs at normal priority: if a reader of the store is slow, SQLite can't shorten its
// log. At SCHED_IDLE, a run's log grew by 1.2 GB in 90 s.
//
// If a checkpoint can't be written, a warning is logged once and the checkpoint is tried again
// later. The run continues and derives an archive at its end anyway.
//
// Thread safety: one thread calls the class.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "common/base/clock.h"
#include "service/coordinator/drive.h"

namespace sleight::coordinator {

/// Maximum ratio of a checkpoint's time to the workers' time between two checkpoints.
inline constexpr double k_checkpoint_share_max = 0.01;
/// Time before the first checkpoint. A run that ends earlier writes its archive anyway.
inline constexpr double k_checkpoint_after_s = 0.5;
/// If the first checkpoint fails or shows no solution, the next try follows after this delay.
inline constexpr double k_checkpoint_retry_s = 1;

class Checkpoints {
 public:
  struct Made {
    bool archive = false;  ///< false: there are no draws and no finds yet
    double motions_s = 0;  ///< processor time that new motions took
  };
  /// Derives the archive of the given cut. Called in the checkpoints' thread. Throws DeriveStopped
  /// (derive.h) soon after `stop` becomes true. On failure, throws any other exception.
  using Derive = std::function<Made(const request::Cut& reached, const std::atomic<bool>& stop)>;

  /// Borrows the clock, which must be thread-safe. `every_s` 0: no checkpoints. `has_archive`: an
  /// earlier session left an archive, so none is needed at once.
  Checkpoints(Derive derive, const base::Clock& clock, double every_s, bool has_archive = false);
  /// As stop().
  ~Checkpoints();
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;

  /// Begins a checkpoint if one is due. May be called at any rate.
  void offer(const Standing& now);

  /// Cancels the checkpoint in progress, waits for the thread, and begins no further checkpoint.
  void stop();

  std::uint64_t made() const;

 private:
  void work();
  bool is_due(const Standing& now) const;
  void complain(const std::string& reason);

  Derive derive_;
  const base::Clock& clock_;
  double every_s_;
  double begin_s_;
  std::atomic<bool> stop_ = false;
  mutable std::mutex mutex_;  ///< guards all members below
  std::condition_variable changed_;
  std::optional<request::Cut> wanted_;  ///< to be made next
  bool is_making_ = false;
  bool has_archive_ = false;        ///< an archive shows a solution
  bool shows_solution_ = false;     ///< the archive in progress shows a solution
  bool is_first_of_finds_ = false;  ///< the first archive with all finds is in progress
  bool has_complained_ = false;
  double last_end_s_;  ///< end of the last try, or begin of the session
  double last_cost_s_ = 0;
  std::uint64_t made_ = 0;
  std::thread thread_;
};

}  // namespace sleight::coordinator
