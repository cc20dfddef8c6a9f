#include "service/coordinator/local_crew.h"

#include <chrono>
#include <utility>

#include "common/base/check.h"

namespace sleight::coordinator {

LocalCrew::LocalCrew(const plan::BlockWorker& worker, std::uint32_t threads)
    : worker_(worker), threads_wanted_(threads) {
  CHECK_GE(threads, 1U);
}

LocalCrew::~LocalCrew() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
    waiting_.clear();
  }
  work_waits_.notify_all();
  for (std::thread& thread : threads_)
    thread.join();
}

std::vector<core::Joined> LocalCrew::members() const {
  return {{.worker = k_local_worker, .incarnation = 0, .threads = threads_wanted_}};
}

void LocalCrew::send(core::WorkerId worker, schema::Assignment assignment) {
  CHECK_EQ(worker, k_local_worker);
  while (threads_.size() < threads_wanted_)
    threads_.emplace_back([this] { work(); });
  {
    const std::scoped_lock lock(mutex_);
    before_it_.insert(assignment.assignment);
    waiting_.push_back(std::move(assignment));
  }
  work_waits_.notify_one();
}

void LocalCrew::send(core::WorkerId worker, const schema::Ping& ping) {
  CHECK_EQ(worker, k_local_worker);
  const std::scoped_lock lock(mutex_);
  schema::Pong pong{.epoch = ping.epoch, .assignments = {before_it_.begin(), before_it_.end()}};
  inputs_.emplace_back(core::Answered{.worker = worker, .pong = std::move(pong)});
}

std::vector<core::Input> LocalCrew::receive(double timeout_s) {
  std::unique_lock lock(mutex_);
  input_waits_.wait_for(lock, std::chrono::duration<double>(timeout_s),
                        [&] { return failure_ || !inputs_.empty(); });
  if (failure_) std::rethrow_exception(failure_);
  return std::exchange(inputs_, {});
}

bool LocalCrew::is_busy() {
  const std::scoped_lock lock(mutex_);
  waiting_.clear();
  return running_ > 0;
}

void LocalCrew::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    work_waits_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
    if (ending_) return;
    const schema::Assignment assignment = std::move(waiting_.front());
    waiting_.pop_front();
    ++running_;
    lock.unlock();
    try {
      schema::Delivery delivery{.epoch = assignment.epoch,
                                .assignment = assignment.assignment,
                                .results = worker_.run(assignment.block, assignment.states),
                                .cache = worker_.cache_use()};
      lock.lock();
      before_it_.erase(assignment.assignment);
      inputs_.emplace_back(
          core::Delivered{.worker = k_local_worker, .delivery = std::move(delivery)});
    } catch (...) {
      if (!lock.owns_lock()) lock.lock();
      failure_ = std::current_exception();
    }
    --running_;
    input_waits_.notify_one();
  }
}

}  // namespace sleight::coordinator
