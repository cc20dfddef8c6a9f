// Archives of a run so far, for people who watch, made beside the computing.
//
// A thread of its own derives them, all but the first at the lowest priority, so that it takes time
// that workers leave and next to none of theirs; nobody waits for it. The first comes with the
// first solution; the next ones every so often, and so seldom that deriving takes at most
// k_checkpoint_share_max of the time.
//
// A checkpoint that can't be written is said once and tried again later: the run goes on, and its
// end derives an archive anyhow.
//
// Thread safety: one thread calls it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "common/base/clock.h"
#include "service/coordinator/drive.h"

namespace sleight::coordinator {

/// Deriving takes no larger share of a run's time.
inline constexpr double k_checkpoint_share_max = 0.01;
/// Before so much of a session nothing is made: a run that is over by then has its archive anyhow.
inline constexpr double k_checkpoint_after_s = 0.5;

class Checkpoints {
 public:
  /// Derives the archive of what was reached, in the thread; throws DeriveStopped (derive.h) soon
  /// after `stop` has become true, and base::Error where it fails.
  using Derive = std::function<void(const Reached& reached, const std::atomic<bool>& stop)>;

  /// Borrows the clock, which must be thread-safe. `every_s` 0: none are made.
  Checkpoints(Derive derive, const base::Clock& clock, double every_s);
  /// As stop().
  ~Checkpoints();
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;

  /// How the run stands, told as often as one likes: begins a checkpoint when it is time for one.
  /// `has_solution`: there is something to see.
  void offer(const Reached& reached, bool has_solution);

  /// Gives up the one that is being made and waits for that; none is begun afterwards.
  void stop();

  std::uint64_t made() const;

 private:
  void work();
  bool is_due(bool has_solution) const;

  Derive derive_;
  const base::Clock& clock_;
  double every_s_;
  double begin_s_;
  std::atomic<bool> stop_ = false;
  mutable std::mutex mutex_;  ///< of all below
  std::condition_variable changed_;
  std::optional<Reached> wanted_;  ///< to be made now
  bool is_making_ = false;
  bool has_seen_solution_ = false;  ///< one of the checkpoints asked for has some
  bool has_complained_ = false;
  double last_end_s_;  ///< of the last one made, or the session's beginning
  double last_cost_s_ = 0;
  std::uint64_t made_ = 0;
  std::thread thread_;
};

}  // namespace sleight::coordinator
