// Ctrl-C and SIGTERM in commands that write files: what is not whole is taken away first.
#pragma once

#include <array>
#include <csignal>

namespace sleight::cli {

/// While it lives, the first such signal is remembered; a second one ends the process at once. One
/// at a time, in the main thread.
class Interruption {
 public:
  Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;
  ~Interruption();

  /// Throws base::Error(interrupted) once the signal has come. Asked between pieces of work.
  static void check();

 private:
  std::array<struct sigaction, 2> before_{};
};

}  // namespace sleight::cli
