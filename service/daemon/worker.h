// A thread for slow work, such as hashing files, deleting folders and deriving archives. Such work
// can wait. Thread safety: `run` is called from one thread.
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

  /// Queues the work. The work must not throw. The work reports its outcome with Loop::post.
  void run(Work work);
  /// Makes ending() true. Waits for the work in progress. Queued work never begins. Call end()
  /// before destroying anything that the work uses. Repeated calls have no effect.
  void end();
  /// True once end() is called; slow work checks it. Callable from any thread.
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
