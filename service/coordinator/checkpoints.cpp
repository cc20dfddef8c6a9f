#include "service/coordinator/checkpoints.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <ctime>
#include <utility>

#include "common/base/error.h"
#include "common/logging/log.h"
#include "service/coordinator/derive.h"

namespace sleight::coordinator {
namespace {

constexpr int k_lowest_priority = 19;

/// Of the calling thread.
double processor_s() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

Checkpoints::Checkpoints(Derive derive, const base::Clock& clock, double every_s)
    : derive_(std::move(derive)),
      clock_(clock),
      every_s_(every_s),
      begin_s_(clock.now_s()),
      last_end_s_(begin_s_) {}

Checkpoints::~Checkpoints() {
  stop();
}

void Checkpoints::offer(const Reached& reached, bool has_solution) {
  if (stop_ || every_s_ <= 0 || (reached.scans == 0 && reached.found == 0)) return;
  {
    const std::scoped_lock lock(mutex_);
    if (is_making_ || wanted_ || !is_due(has_solution)) return;
    wanted_ = reached;
    has_seen_solution_ = has_seen_solution_ || has_solution;
    if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
  }
  changed_.notify_all();
}

bool Checkpoints::is_due(bool has_solution) const {
  const double now_s = clock_.now_s();
  if (has_solution && !has_seen_solution_) return now_s - begin_s_ >= k_checkpoint_after_s;
  const double since_s = now_s - last_end_s_;
  return since_s >= every_s_ && last_cost_s_ <= k_checkpoint_share_max * since_s;
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
    const Reached reached = *std::exchange(wanted_, std::nullopt);
    is_making_ = true;
    lock.unlock();

    const double begin_s = processor_s();
    bool is_made = false;
    std::string complaint;
    try {
      derive_(reached, stop_);
      is_made = true;
    } catch (const DeriveStopped&) {
    } catch (const base::Error& failure) {
      complaint = failure.what();
    }
    const double cost_s = processor_s() - begin_s;

    // The first one is small and waited for. A thread of Linux has a priority of its own.
    if (is_made) ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), k_lowest_priority);

    lock.lock();
    is_making_ = false;
    last_end_s_ = clock_.now_s();
    last_cost_s_ = cost_s;
    made_ += is_made ? 1 : 0;
    if (!complaint.empty() && !std::exchange(has_complained_, true)) {
      logging::warn(fmt::format("no archive of the run so far: {}", complaint));
    }
  }
}

}  // namespace sleight::coordinator
