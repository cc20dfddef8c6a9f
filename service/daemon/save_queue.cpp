#include "service/daemon/save_queue.h"

#include <chrono>
#include <utility>

#include "common/base/error.h"

namespace sleight::daemon {

SaveQueue::SaveQueue(JobStore store, Post post, std::function<void(const std::string&)> stalled)
    : store_(std::move(store)),
      post_(std::move(post)),
      stalled_(std::move(stalled)),
      thread_([this] { work(); }) {}

SaveQueue::~SaveQueue() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
  if (is_over_) return;
  try {
    store_.empty_log();
  } catch (const base::Error&) {
    // The next daemon reads the log.
  }
}

void SaveQueue::put(std::optional<Save> save, Callback then) {
  {
    const std::scoped_lock lock(mutex_);
    queue_.push_back({std::move(save), std::move(then)});
  }
  changed_.notify_all();
}

void SaveQueue::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return ending_ || !queue_.empty(); });
    if (queue_.empty()) return;
    std::vector<Waiting> group = std::exchange(queue_, {});
    lock.unlock();
    bool saved = save(group);
    lock.lock();
    while (!saved && !ending_ && !is_over_) {
      changed_.wait_for(lock, std::chrono::duration<double>(k_retry_s), [&] { return ending_; });
      lock.unlock();
      saved = save(group);
      lock.lock();
    }
    if (!saved) return;
  }
}

/// Returns whether the group is durable.
bool SaveQueue::save(std::vector<Waiting>& group) {
  std::vector<const Save*> saves;
  for (const Waiting& waiting : group)
    if (waiting.save) saves.push_back(&*waiting.save);
  try {
    store_.save(saves);
  } catch (const base::Error& failure) {
    if (failure.exit_code() == base::ExitCode::conflict) {
      // Another daemon may have the folder. Write nothing more, and make the owner end.
      is_over_ = true;
      post_([failure] { throw failure; });
      return false;
    }
    is_stalled_ = true;
    post_([this, reason = std::string(failure.what())] { stalled_(reason); });
    return false;
  }
  if (std::exchange(is_stalled_, false)) post_([this] { stalled_({}); });
  post_([thens = std::move(group)] {
    for (const Waiting& waiting : thens)
      if (waiting.then) waiting.then();
  });
  return true;
}

}  // namespace sleight::daemon
