// Archives of a run so far, for people who watch, made beside the computing.
//
// A thread of its own derives them, so that nobody waits. The first comes as soon as a search has
// its finds, or with the first solution;
// the next ones every so often, and so seldom that they take at most k_checkpoint_share_max of the
// workers' time. Motions of kept animations are not counted: each is simulated once for all
// archives, the last one too, and so costs nothing more.
//
// At a low priority it would cost less, but a thread that reads the store slowly keeps SQLite from
// cutting its log short: at SCHED_IDLE a run's log grew by 1.2 GB in a minute and a half.
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
#include <string>
#include <thread>

#include "common/base/clock.h"
#include "service/coordinator/drive.h"

namespace sleight::coordinator {

/// Of the workers' time between two checkpoints, one takes no larger share.
inline constexpr double k_checkpoint_share_max = 0.01;
/// Before so much of a session nothing is made: a run that is over by then has its archive anyhow.
inline constexpr double k_checkpoint_after_s = 0.5;
/// A first one that could not be made, or shows nothing yet, is tried again after so long.
inline constexpr double k_checkpoint_retry_s = 1;

class Checkpoints {
 public:
  struct Made {
    bool archive = false;  ///< false: there are no draws and no finds yet
    double motions_s = 0;  ///< processor time that new motions took
  };
  /// Derives the archive of what was reached, in the thread; throws DeriveStopped (derive.h) soon
  /// after `stop` has become true, and any other exception where it fails.
  using Derive = std::function<Made(const request::Cut& reached, const std::atomic<bool>& stop)>;

  /// Borrows the clock, which must be thread-safe. `every_s` 0: none are made. `has_archive`: an
  /// earlier session left one, so that none is made at once.
  Checkpoints(Derive derive, const base::Clock& clock, double every_s, bool has_archive = false);
  /// As stop().
  ~Checkpoints();
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;

  /// How the run stands, told as often as one likes: begins a checkpoint when it is time for one.
  void offer(const Standing& now);

  /// Gives up the one that is being made and waits for that; none is begun afterwards.
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
  mutable std::mutex mutex_;  ///< of all below
  std::condition_variable changed_;
  std::optional<request::Cut> wanted_;  ///< to be made now
  bool is_making_ = false;
  bool has_archive_ = false;        ///< one that shows a solution
  bool shows_solution_ = false;     ///< the one that is being made does
  bool is_first_of_finds_ = false;  ///< so is all that a search was to find, and no archive was
  bool has_complained_ = false;
  double last_end_s_;  ///< of the last try, or the session's beginning
  double last_cost_s_ = 0;
  std::uint64_t made_ = 0;
  std::thread thread_;
};

}  // namespace sleight::coordinator
