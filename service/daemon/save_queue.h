// Makes saves durable on a thread of its own, in groups: whatever has come while one group was
// written is the next. So many submits share a sync of the disk, and the loop never waits for one.
//
// Invariants
//   1. Saves become durable in the order in which they are put, each whole or not at all.
//   2. A save's `then` is posted once it is durable, in the same order, and never before.
//   3. A disk that fails loses nothing: the group is tried again every k_retry_s until it is
//      durable, and what waits for it waits.
//   4. Where the store's lock is lost nothing more is saved, and the error is thrown in the owner's
//      thread.
//
// Thread safety: put is called from one thread; `post` must be callable from any.
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
  /// Calls it soon, in the owner's thread.
  using Post = std::function<void(Callback)>;

  /// `stalled` is posted with the disk's reason when a group can't be saved, and empty when it is
  /// after all.
  SaveQueue(JobStore store, Post post, std::function<void(const std::string&)> stalled);
  /// Tries once more to save what was put; `then`s are not called any more.
  ~SaveQueue();
  SaveQueue(const SaveQueue&) = delete;
  SaveQueue& operator=(const SaveQueue&) = delete;

  /// Without a save `then` keeps its place in the order all the same.
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
  bool is_over_ = false;     ///< likewise: the lock is lost
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace sleight::daemon
