// One thread for what takes long and may wait its turn: hashing files, deleting folders; another
// one for deriving archives.
//
// Thread safety: `run` is called from one thread.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace sleight::daemon {

class Worker {
 public:
  using Work = std::function<void()>;

  Worker();
  ~Worker() { end(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// In order. `work` must not throw, and says by Loop::post what came of it.
  void run(Work work);
  /// Waits for the work that has begun, which `ending` tells; what has not begun never does. By who
  /// owns what the work uses, before that goes; once more does nothing.
  void end();
  /// True from the beginning of its end: work that takes long looks at it. Any thread.
  const std::atomic<bool>& ending() const { return ending_; }

 private:
  void go_on();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Work> queue_;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

}  // namespace sleight::daemon
