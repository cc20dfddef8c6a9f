// Ctrl-C and SIGTERM, for commands that end in order when they come.
#pragma once

#include <signal.h>

#include <array>
#include <functional>

namespace sleight::terminal {

/// While it lives, the first such signal is remembered, and a system call that waits returns; a
/// second one ends the process at once. One at a time, in the main thread.
class Interruption {
 public:
  /// `also` is called by the signal handler: it must be safe there, as rpc::Client::interrupt is.
  explicit Interruption(std::function<void()> also = {});
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;
  ~Interruption();

  static bool requested();
  /// Throws base::Error(interrupted) once the signal has come. Asked between pieces of work.
  static void check();

 private:
  std::function<void()> also_;
  std::array<struct sigaction, 2> before_{};
};

}  // namespace sleight::terminal
