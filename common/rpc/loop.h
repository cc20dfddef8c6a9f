// The one thread that a service runs on: it waits for clients, timers, files and other threads, and
// calls what was asked for, one thing at a time.
//
// Invariants
//   1. Callbacks run on the thread that called run(), never inside a call of this class.
//   2. Destroying a Handle ends it at once: its callback is not called any more. A Handle may be
//      destroyed inside its own callback.
//   3. Destroy every Handle, and every Server, before the Loop.
//
// A callback that throws ends run() with that exception: the daemon's main hears of it.
//
// Thread safety: `post` and `stop` may be called from any thread; `stop` also from a signal
// handler. All else belongs to the thread that made the Loop. A thread has one Loop at most, and no
// Client is used in it (client.h): that one waits.
#pragma once

#include <functional>
#include <memory>

namespace sleight::rpc {

class Loop {
 public:
  /// What ends with its owner: a timer or a look at a file. Moves, does not copy.
  class Handle {
   public:
    Handle();
    ~Handle();
    Handle(Handle&&) noexcept;
    Handle& operator=(Handle&&) noexcept;
    struct State;  ///< of loop.cpp
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

  /// Until stop(), also one that was called before.
  void run();
  /// Makes run() return soon.
  void stop();

  /// Once, after so long.
  [[nodiscard]] Handle call_later(double seconds, Callback callback);
  /// Again and again; where the loop was kept from it, missed calls are not made up for.
  [[nodiscard]] Handle call_every(double seconds, Callback callback);
  /// While there is something to read from the descriptor, or its other end is closed; called again
  /// until it is read. REQUIRES: the descriptor stays open as long as the Handle.
  [[nodiscard]] Handle call_when_readable(int descriptor, Callback callback);
  /// On the loop's thread, in the order in which they are posted; what is posted after run() has
  /// returned is dropped with the Loop.
  void post(Callback callback);

  /// From now on SIGTERM, SIGINT and SIGHUP call this instead of ending the process; no signal is
  /// blocked, so that processes started from here have what they expect. At most one Loop of a
  /// process has it.
  void on_stop_signals(std::function<void(int signal)> callback);

  struct Impl;  ///< of loop_impl.h
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace sleight::rpc
