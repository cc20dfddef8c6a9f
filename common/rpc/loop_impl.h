// The KJ event loop inside a Loop, for server.cpp.
#pragma once

#include <kj/async-io.h>
#include <kj/async-unix.h>
#include <kj/io.h>

#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "common/rpc/loop.h"

namespace sleight::rpc {

struct Loop::Impl final : kj::TaskSet::ErrorHandler {
  Impl();
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  kj::Timer& timer() { return io.provider->getTimer(); }
  /// What a callback threw: run() throws it again.
  void fail(std::exception_ptr error);
  /// Calls it, and fails with what it throws.
  void call(const Callback& callback);
  void taskFailed(kj::Exception&& exception) override;
  void wake_up() const;
  void run_posted();
  kj::Promise<void> look_at_wake();
  kj::Promise<void> look_at_signals();

  kj::AsyncIoContext io;
  kj::AutoCloseFd wake_descriptor;  ///< written by post and stop
  kj::AutoCloseFd
      signal_descriptor;  ///< written by the signal handler; none: signals are not asked for
  kj::UnixEventPort::FdObserver wakes;
  kj::Own<kj::UnixEventPort::FdObserver> signals;
  std::atomic<bool> is_stopped = false;
  std::exception_ptr error;
  kj::Own<kj::PromiseFulfiller<void>> running;  ///< ends run()
  std::mutex posted_mutex;
  std::vector<Callback> posted;  ///< guarded by the mutex
  std::function<void(int)> on_signal;
  kj::TaskSet tasks;  ///< the last one: it looks at what stands above
};

}  // namespace sleight::rpc
