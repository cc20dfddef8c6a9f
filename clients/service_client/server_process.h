// Starts a daemon that outlives this process.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace sleight::service_client {

/// Returns the program with this name in this program's folder. Throws base::Error if there is no
/// such program.
std::string program_beside(const std::string& name);

/// Replaces this process by the command. Throws base::Error on failure.
[[noreturn]] void become(const std::vector<std::string>& command);

/// A daemon in its own session, so that it survives its terminal. The daemon's input is empty, and
/// its output is appended to `server.log` in its state folder, which is created for its owner only.
/// The daemon inherits nothing else. Not thread-safe.
class ServerProcess {
 public:
  /// Throws base::Error if the folder, the log or the process can't be created.
  ServerProcess(const std::vector<std::string>& command, const std::string& state_folder);
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  pid_t pid() const { return pid_; }
  const std::string& log_path() const { return log_path_; }
  bool is_running();
  /// Returns an exited daemon's exit code if this is 1 to 5 or 9, otherwise `environment`.
  base::ExitCode exit_code() const;
  /// Returns the last lines logged since the start.
  std::vector<std::string> log_lines(std::size_t count_max) const;

 private:
  std::string log_path_;
  std::uint64_t log_began_ = 0;
  pid_t pid_ = -1;
  bool has_ended_ = false;
  int status_ = 0;
};

}  // namespace sleight::service_client
