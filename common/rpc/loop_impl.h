// The KJ event loop inside a Loop, for server.cpp.
#pragma once

#include <kj/async-io.h>
#include <kj/async-unix.h>
#include <kj/io.h>

#include <atomic>
#include <exception>
#include <functional>
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
  /// Stores a callback's exception, and makes run() rethrow it.
  void fail(std::exception_ptr error);
  /// Calls `callback`; fails with any exception that it throws.
  void call(const Callback& callback);
  void taskFailed(kj::Exception&& exception) override;
  void wake_up() const;
  void run_posted();
  kj::Promise<void> look_at_wake();
  kj::Promise<void> look_at_signals();

  kj::AsyncIoContext io;
  kj::AutoCloseFd wake_descriptor;    ///< written by post and stop
  kj::AutoCloseFd signal_descriptor;  ///< written by the signal handler; none: signals not handled
  kj::UnixEventPort::FdObserver wakes;
  kj::Own<kj::UnixEventPort::FdObserver> signals;
  std::atomic<bool> is_stopped = false;
  std::exception_ptr error;
  kj::Own<kj::PromiseFulfiller<void>> running;  ///< ends run()
  std::mutex posted_mutex;
  std::vector<Callback> posted;  ///< guarded by the mutex
  std::function<void(int)> on_signal;
  kj::TaskSet tasks;  ///< last member: its tasks use the members above
};

}  // namespace sleight::rpc
