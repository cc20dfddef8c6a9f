// The single-threaded event loop of a service: waits for clients, timers, files and other threads,
// and runs callbacks one at a time.
//
// Invariants
//   1. Callbacks run on the thread that called run(), never inside another function of this class.
//   2. Destroying a Handle takes effect at once: its callback is not called any more. A callback
//      may destroy its own Handle.
//   3. Destroy every Handle and every Server before the Loop.
//
// If a callback throws, run() ends and throws that exception.
//
// Thread safety: `post` and `stop` may be called from any thread, and `stop` also from a signal
// handler. All other functions belong to the thread that made the Loop. A thread has at most one
// Loop and must not use a Client (client.h), because a Client blocks.
#pragma once

#include <functional>
#include <memory>

namespace sleight::rpc {

class Loop {
 public:
  /// A timer or a watched file is active as long as its Handle lives. Movable, not copyable.
  class Handle {
   public:
    Handle();
    ~Handle();
    Handle(Handle&&) noexcept;
    Handle& operator=(Handle&&) noexcept;
    struct State;  ///< in loop.cpp
    explicit Handle(std::shared_ptr<State> state);

   private:
    void end();
    std::shared_ptr<State> state_;
  };

  using Callback = std::function<void()>;

  Loop();
  ~Loop();
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  /// Runs until stop(). If stop() was called before, returns at once.
  void run();
  void stop();

  /// Calls `callback` once, after `seconds`.
  [[nodiscard]] Handle call_later(double seconds, Callback callback);
  /// Calls `callback` periodically. Calls missed while the loop was busy are skipped.
  [[nodiscard]] Handle call_every(double seconds, Callback callback);
  /// While the descriptor is readable or its other end is closed, calls `callback` repeatedly.
  /// REQUIRES: the descriptor stays open as long as the Handle.
  [[nodiscard]] Handle call_when_readable(int descriptor, Callback callback);
  /// Calls `callback` on the loop's thread, in the order of posting. If a callback is posted after
  /// the last run() has returned, it is never called.
  void post(Callback callback);

  /// From now on SIGTERM, SIGINT and SIGHUP call `callback` instead of ending the process. No
  /// signal is blocked, so that child processes start with the usual mask. At most one Loop per
  /// process may use this.
  void on_stop_signals(std::function<void(int signal)> callback);

  struct Impl;  ///< in loop_impl.h
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace sleight::rpc
