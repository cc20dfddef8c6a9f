#include "service/coordinator/local_executor.h"

#include <chrono>

#include "common/base/check.h"

namespace sleight::coordinator {

LocalExecutor::LocalExecutor(const plan::UnitWorker& worker, const base::Clock& clock,
                             std::size_t threads)
    : worker_(worker), clock_(clock), threads_wanted_(threads) {
  CHECK_GE(threads, 1U);
}

LocalExecutor::~LocalExecutor() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
    waiting_.clear();
  }
  work_waits_.notify_all();
  for (std::thread& thread : threads_)
    thread.join();
}

std::size_t LocalExecutor::room() const {
  // One unit per thread in hand and one waiting, so that no thread waits for the driver.
  const std::size_t most = 2 * threads_wanted_;
  return outstanding_ < most ? most - outstanding_ : 0;
}

void LocalExecutor::submit(const plan::Unit& unit, base::Bytes state) {
  while (threads_.size() < threads_wanted_)
    threads_.emplace_back([this] { work(); });
  ++outstanding_;
  {
    const std::scoped_lock lock(mutex_);
    waiting_.emplace_back(unit, std::move(state));
  }
  work_waits_.notify_one();
}

std::vector<plan::UnitResult> LocalExecutor::wait(double timeout_s) {
  std::unique_lock lock(mutex_);
  result_waits_.wait_for(lock, std::chrono::duration<double>(timeout_s),
                         [&] { return failure_ || !done_.empty(); });
  if (failure_) std::rethrow_exception(failure_);
  std::vector<plan::UnitResult> results = std::exchange(done_, {});
  outstanding_ -= results.size();
  return results;
}

void LocalExecutor::drop_waiting() {
  const std::scoped_lock lock(mutex_);
  outstanding_ -= waiting_.size();
  waiting_.clear();
}

void LocalExecutor::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    work_waits_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
    if (ending_) return;
    const auto [unit, state] = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    try {
      const double begin_s = clock_.now_s();
      plan::UnitResult result = worker_.run(unit, state);
      result.cost_s = clock_.now_s() - begin_s;
      lock.lock();
      done_.push_back(std::move(result));
    } catch (...) {
      if (!lock.owns_lock()) lock.lock();
      failure_ = std::current_exception();
    }
    result_waits_.notify_one();
  }
}

}  // namespace sleight::coordinator
