// Runs a program to its end and hears what it prints: for short work that the daemon leaves to the
// programs themselves, such as deriving an archive.
//
// The program gets an argument array (no shell), nothing to read, the environment that jobs get
// (keeper/command.h), and dies with the thread that waits for it.
//
// Thread safety: any thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <string>
#include <vector>

namespace sleight::daemon {

struct ChildOptions {
  double seconds_max = 60;  ///< then it is killed
  /// Likewise soon after this has become true; null: never.
  const std::atomic<bool>* stop = nullptr;
  bool yields = false;  ///< it runs at a low priority
  std::size_t output_bytes_max = 64U << 10U;
};

struct ChildEnd {
  int exit_code = -1;         ///< -1: it did not exit by itself
  bool was_too_slow = false;  ///< and was killed
  std::string output{};       ///< stdout and stderr together; its beginning, where there is more
};

/// Throws base::Error where the program can't be started.
ChildEnd run_child(const std::vector<std::string>& command, const ChildOptions& options = {});

}  // namespace sleight::daemon
