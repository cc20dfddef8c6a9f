#include "common/store/group_commit.h"

#include <chrono>
#include <utility>

namespace sleight::store {
namespace {

/// Returns the approximate size of a result in the queue. The limits of memory and groups use this
/// size.
std::size_t bytes_of(const plan::UnitResult& result) {
  std::size_t bytes = sizeof(result) + result.state_after.size();
  for (const plan::ScanRecord& scan : result.scans) {
    bytes += sizeof(scan) + scan.state.size() + 8 * scan.outcome.size() +
             4 * (scan.proposed.size() + scan.accepted.size());
  }
  return bytes;
}

std::size_t bytes_of(const PutEvents& put) {
  return sizeof(put) + put.events.size() * sizeof(events::RunEvent);
}

bool is_empty(const GroupCommit::Group& group) {
  return group.results.empty() && group.events.empty();
}

}  // namespace

GroupCommit::GroupCommit(Commit commit) : commit_(std::move(commit)) {}

GroupCommit::~GroupCommit() {
  end();
}

void GroupCommit::end() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void GroupCommit::rethrow_failure() const {
  if (failure_) std::rethrow_exception(failure_);
}

void GroupCommit::put(plan::UnitResult result) {
  put_into(&Group::results, std::move(result));
}

void GroupCommit::put(PutEvents events) {
  put_into(&Group::events, std::move(events));
}

template <class T>
void GroupCommit::put_into(std::vector<T> Group::*part, T what) {
  const std::size_t bytes = bytes_of(what);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ || queue_bytes_ < k_queue_bytes_max; });
  rethrow_failure();
  if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
  const bool is_first = is_empty(queue_);
  (queue_.*part).push_back(std::move(what));
  queue_bytes_ += bytes;
  ++put_;
  // Wake the writer for a group's first entry and for its last. The first entry starts the group's
  // waiting time.
  if (is_first || queue_bytes_ >= k_group_bytes) changed_.notify_all();
}

void GroupCommit::flush() {
  std::unique_lock lock(mutex_);
  // Wait only for entries that are already in the queue. Other threads might never stop adding new
  // ones.
  const std::uint64_t wanted = put_;
  ++flushing_;
  changed_.notify_all();
  changed_.wait(lock, [&] { return failure_ || committed_ >= wanted; });
  --flushing_;
  rethrow_failure();
}

std::uint64_t GroupCommit::committed() const {
  const std::scoped_lock lock(mutex_);
  return committed_scans_;
}

void GroupCommit::work() {
  std::unique_lock lock(mutex_);
  while (!failure_) {
    changed_.wait(lock, [&] { return ending_ || !is_empty(queue_); });
    if (is_empty(queue_)) return;

    // Wait for more entries, unless a caller is waiting in flush().
    changed_.wait_for(lock, std::chrono::duration<double>(k_group_wait_s),
                      [&] { return ending_ || flushing_ > 0 || queue_bytes_ >= k_group_bytes; });
    Group group = std::exchange(queue_, {});
    queue_bytes_ = 0;
    lock.unlock();

    std::exception_ptr failure;
    std::uint64_t scans = 0;
    try {
      commit_(group);
      for (const plan::UnitResult& result : group.results)
        scans += result.unit.draws_prior() ? 0 : result.scans.size();
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    committed_scans_ += scans;
    if (!failure) committed_ += group.results.size() + group.events.size();
    failure_ = failure;
    changed_.notify_all();
  }
}

}  // namespace sleight::store
