// Runs a program to its end, for short work: one of a batch system, or one of ours that makes an
// archive. An argument array (no shell), a text to read, a deadline, bounded answers.
//
// The program has a session of its own, which is killed at the deadline, so that nothing that it
// started is waited for. It dies with the thread that waits for it (program.h).
//
// Thread safety: any thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <string>
#include <vector>

namespace sleight::keeper {

struct ToolOptions {
  std::string input{};  ///< what it reads
  double seconds_max = 60;
  std::size_t output_bytes_max = std::size_t{64} << 20U;
  std::size_t words_bytes_max = 64U << 10U;
  std::vector<std::string> environment{};  ///< command.h has some
  bool yields = false;                     ///< it runs at a low priority
  /// Killed soon after this has become true; null: never.
  const std::atomic<bool>* stop = nullptr;
};

struct ToolEnd {
  int exit_code = -1;         ///< -1: it did not exit by itself
  bool was_too_slow = false;  ///< and was killed
  bool is_cut = false;        ///< it printed more than was taken
  std::string output{};       ///< stdout
  std::string words{};        ///< stderr: lines without control characters

  /// For people, on one line: what it said, or how it ended.
  std::string why() const;
};

/// Throws base::Error where the program can't be started. `command`'s program is looked for on
/// PATH.
ToolEnd run_tool(const std::vector<std::string>& command, const ToolOptions& options);

/// This process's environment without variables of those beginnings, but for those in `kept`.
std::vector<std::string> environment_without(const std::vector<std::string>& beginnings,
                                             const std::vector<std::string>& kept = {});

}  // namespace sleight::keeper
