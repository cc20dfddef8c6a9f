#include "service/coordinator/checkpoints.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <new>
#include <system_error>
#include <utility>

#include "common/base/memory.h"
#include "common/logging/log.h"
#include "service/coordinator/derive.h"

namespace sleight::coordinator {

Checkpoints::Checkpoints(Derive derive, const base::Clock& clock, double every_s, bool has_archive)
    : derive_(std::move(derive)),
      clock_(clock),
      every_s_(every_s),
      begin_s_(clock.now_s()),
      has_archive_(has_archive),
      last_end_s_(begin_s_) {}

Checkpoints::~Checkpoints() {
  stop();
}

void Checkpoints::offer(const Standing& now) {
  if (stop_ || every_s_ <= 0 || (now.reached.scans == 0 && now.reached.found == 0)) return;
  {
    const std::scoped_lock lock(mutex_);
    if (is_making_ || wanted_ || !is_due(now)) return;
    try {
      if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
    } catch (const std::system_error& failure) {
      complain(failure.what());
      last_end_s_ = clock_.now_s();
      return;
    }
    wanted_ = now.reached;
    is_first_of_finds_ = now.has_finds && !has_archive_;
    shows_solution_ = now.has_solution;
  }
  changed_.notify_all();
}

bool Checkpoints::is_due(const Standing& now) const {
  const double now_s = clock_.now_s();
  const double since_s = now_s - last_end_s_;
  const double work_s = since_s * static_cast<double>(std::max<std::size_t>(1, now.workers));
  if (last_cost_s_ > k_checkpoint_share_max * work_s) return false;
  if (now.has_solution && !has_archive_) {
    if (now.has_finds && last_end_s_ == begin_s_) return true;
    return last_end_s_ == begin_s_ ? since_s >= k_checkpoint_after_s
                                   : since_s >= std::min(every_s_, k_checkpoint_retry_s);
  }
  return since_s >= every_s_;
}

/// Logs the first failure only.
void Checkpoints::complain(const std::string& reason) {
  if (std::exchange(has_complained_, true)) return;
  logging::warn(fmt::format("can't write an archive of the run so far: {}", reason));
}

void Checkpoints::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::uint64_t Checkpoints::made() const {
  const std::scoped_lock lock(mutex_);
  return made_;
}

void Checkpoints::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return stop_ || wanted_; });
    if (stop_) return;
    const request::Cut reached = *std::exchange(wanted_, std::nullopt);
    // A stop doesn't cancel the first archive that has all finds. This archive is small, and people
    // wait for it.
    const std::atomic<bool> never = false;
    const std::atomic<bool>& stop = is_first_of_finds_ ? never : stop_;
    is_making_ = true;
    lock.unlock();

    const double begin_s = base::thread_processor_s();
    Made result;
    std::string complaint;
    try {
      result = derive_(reached, stop);
    } catch (const DeriveStopped&) {
    } catch (const std::bad_alloc&) {
      complaint = base::k_too_little_memory;
    } catch (const std::exception& failure) {
      complaint = failure.what();
    }
    const double cost_s = base::thread_processor_s() - begin_s - result.motions_s;

    lock.lock();
    is_making_ = false;
    last_end_s_ = clock_.now_s();
    last_cost_s_ = cost_s;
    made_ += result.archive ? 1 : 0;
    has_archive_ = has_archive_ || (result.archive && shows_solution_);
    if (!complaint.empty()) complain(complaint);
  }
}

}  // namespace sleight::coordinator
