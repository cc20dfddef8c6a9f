// Threads of this process that compute units.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "service/coordinator/executor.h"

namespace sleight::coordinator {

/// Each thread takes the oldest unit. submit, wait and the counts are for one driving thread. The
/// threads start with the first unit: until then the process may fork safely, which reading a file
/// that may be anything does.
class LocalExecutor final : public Executor {
 public:
  /// Borrows the worker and the clock. REQUIRES: threads >= 1.
  LocalExecutor(const plan::UnitWorker& worker, const base::Clock& clock, std::size_t threads);
  /// Lets running units end and drops waiting ones.
  ~LocalExecutor() override;
  LocalExecutor(const LocalExecutor&) = delete;
  LocalExecutor& operator=(const LocalExecutor&) = delete;

  std::size_t room() const override;
  void submit(const plan::Unit& unit, base::Bytes state) override;
  std::vector<plan::UnitResult> wait(double timeout_s) override;
  void drop_waiting() override;
  std::size_t outstanding() const override { return outstanding_; }
  std::size_t workers() const override { return threads_wanted_; }

 private:
  void work();

  const plan::UnitWorker& worker_;
  const base::Clock& clock_;
  const std::size_t threads_wanted_;
  std::size_t outstanding_ = 0;  // of the driving thread alone
  std::mutex mutex_;
  std::condition_variable work_waits_;
  std::condition_variable result_waits_;
  std::deque<std::pair<plan::Unit, base::Bytes>> waiting_;
  std::vector<plan::UnitResult> done_;
  std::exception_ptr failure_;
  bool ending_ = false;
  std::vector<std::thread> threads_;  // last: they use all of the above
};

}  // namespace sleight::coordinator
