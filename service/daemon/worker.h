// One thread for what takes long and may wait its turn: hashing files, deriving archives, deleting
// folders.
//
// Thread safety: `run` is called from one thread.
#pragma once

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
  /// Waits for the work that has begun; what has not is dropped.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// In order. `work` must not throw, and says by Loop::post what came of it.
  void run(Work work);

 private:
  void go_on();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Work> queue_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace sleight::daemon
