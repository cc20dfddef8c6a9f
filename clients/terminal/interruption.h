// Handles Ctrl-C and SIGTERM, so that commands can end in an orderly way.
#pragma once

#include <signal.h>

#include <array>
#include <functional>

namespace sleight::terminal {

/// While an Interruption exists, the first signal sets a flag and interrupts a waiting system call;
/// the second signal ends the process at once. REQUIRES: only one Interruption exists at a time, in
/// the main thread.
class Interruption {
 public:
  /// The signal handler calls `also`, which must be async-signal-safe, like rpc::Client::interrupt.
  explicit Interruption(std::function<void()> also = {});
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;
  ~Interruption();

  static bool requested();
  /// Throws base::Error(interrupted) after the signal. Call check() between pieces of work.
  static void check();

 private:
  std::function<void()> also_;
  std::array<struct sigaction, 2> before_{};
};

}  // namespace sleight::terminal
