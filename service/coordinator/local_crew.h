// Threads of this process that compute blocks. All threads together are worker number 0.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "service/coordinator/crew.h"

namespace sleight::coordinator {

inline constexpr core::WorkerId k_local_worker{0};

/// Each thread takes the oldest assignment. Only the driving thread calls send() and receive(). The
/// threads start at the first assignment. Before that, the process may fork in order to read
/// untrusted files.
class LocalCrew final : public Crew {
 public:
  /// Borrows the worker. REQUIRES: threads >= 1.
  LocalCrew(const plan::BlockWorker& worker, std::uint32_t threads);
  /// Waits for running blocks and drops waiting blocks.
  ~LocalCrew() override;
  LocalCrew(const LocalCrew&) = delete;
  LocalCrew& operator=(const LocalCrew&) = delete;

  std::vector<core::Joined> members() const override;
  void send(core::WorkerId worker, schema::Assignment assignment) override;
  void send(core::WorkerId worker, const schema::Ping& ping) override;
  std::vector<core::Input> receive(double timeout_s) override;
  /// Returns whether a thread is running a block. If a block is running when a run ends, the
  /// program should exit without destroying the crew: the destructor would wait for the block.
  bool is_busy();

 private:
  void work();

  const plan::BlockWorker& worker_;
  const std::uint32_t threads_wanted_;
  std::mutex mutex_;
  std::condition_variable work_waits_;
  std::condition_variable input_waits_;
  std::deque<schema::Assignment> waiting_;
  std::set<std::uint64_t> before_it_;  ///< assignments that aren't done
  std::size_t running_ = 0;            ///< threads with an assignment
  std::vector<core::Input> inputs_;
  std::exception_ptr failure_;
  bool ending_ = false;
  std::vector<std::thread> threads_;  // last: they use all of the above
};

}  // namespace sleight::coordinator
