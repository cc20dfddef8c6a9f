// Saves the daemon's changes in a separate thread, in groups. All saves that arrive while a group
// is written form the next group. So one sync serves several submits, and the loop never waits for
// the disk.
//
// Invariants
//   1. Saves become durable in the order of `put`. Each is saved completely or not at all.
//   2. A save's `then` is posted after the save is durable. The order is that of `put`.
//   3. A failing disk loses nothing. If a group fails, it is retried every k_retry_s until it is
//      durable. Later saves wait.
//   4. If the store's lock is lost, nothing more is saved, and the error is thrown in the owner's
//      thread.
//
// Thread safety: one thread calls put(); `post` must be callable from any thread.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "service/daemon/job_store.h"

namespace sleight::daemon {

inline constexpr double k_retry_s = 1;

class SaveQueue {
 public:
  using Callback = std::function<void()>;
  /// Calls the callback soon, in the owner's thread.
  using Post = std::function<void(Callback)>;

  /// If saving fails, `stalled` is posted with the disk's error. When saving works again, it is
  /// posted with an empty text.
  SaveQueue(JobStore store, Post post, std::function<void(const std::string&)> stalled);
  /// Tries once more to save the queue. Calls no `then`.
  ~SaveQueue();
  SaveQueue(const SaveQueue&) = delete;
  SaveQueue& operator=(const SaveQueue&) = delete;

  /// Posts `then` after all earlier callbacks. If there is a `save`, first stores it.
  void put(std::optional<Save> save, Callback then);

 private:
  struct Waiting {
    std::optional<Save> save;
    Callback then;
  };
  void work();
  bool save(std::vector<Waiting>& group);

  JobStore store_;
  Post post_;
  std::function<void(const std::string&)> stalled_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Waiting> queue_;
  bool is_stalled_ = false;  ///< of the thread
  bool is_over_ = false;     ///< the lock is lost; of the thread
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace sleight::daemon
