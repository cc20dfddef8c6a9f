// Runs a short program to its end. Such programs are a batch system's commands, and commands that
// write an archive. Arguments are an array (no shell); input is a text; time and output are
// limited.
//
// The program has its own session. At the deadline, the whole session is killed. So the program's
// descendants aren't awaited. The program dies with the calling thread (program.h).
//
// Thread safety: any thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <string>
#include <vector>

namespace sleight::keeper {

struct ToolOptions {
  std::string input{};  ///< the program's stdin
  double seconds_max = 60;
  std::size_t output_bytes_max = std::size_t{64} << 20U;
  std::size_t words_bytes_max = 64U << 10U;
  std::vector<std::string> environment{};  ///< see command.h
  bool yields = false;                     ///< run at low priority
  /// Kills the program soon after `*stop` becomes true. Null: never.
  const std::atomic<bool>* stop = nullptr;
};

struct ToolEnd {
  int exit_code = -1;         ///< -1: killed by a signal
  bool was_too_slow = false;  ///< killed at the deadline
  bool is_cut = false;        ///< some output was dropped
  std::string output{};       ///< stdout
  std::string words{};        ///< stderr: lines without control characters

  /// Returns a line for people. The line is the program's message or says how the program ended.
  std::string why() const;
};

/// Throws base::Error if the program can't be started. If a name has no slash, it is searched on
/// PATH.
ToolEnd run_tool(const std::vector<std::string>& command, const ToolOptions& options);

/// Returns this process's environment. Leaves out a variable if its name begins with one of
/// `beginnings` and with none of `kept`.
std::vector<std::string> environment_without(const std::vector<std::string>& beginnings,
                                             const std::vector<std::string>& kept = {});

}  // namespace sleight::keeper
