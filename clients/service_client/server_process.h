// A daemon that is started from here and outlives this process.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace sleight::service_client {

/// The program of that name in the folder of this one. Throws base::Error where there is none.
std::string program_beside(const std::string& name);

/// Becomes this command, with this process's terminal. Throws base::Error where it can't.
[[noreturn]] void become(const std::vector<std::string>& command);

/// In a session of its own: no terminal's end reaches it. Its input is empty, its output goes to
/// the end of `server.log` in its state folder, which is made, for its owner alone. It inherits
/// nothing else. Not thread-safe.
class ServerProcess {
 public:
  /// Throws base::Error where the folder, the log or the process can't be made.
  ServerProcess(const std::vector<std::string>& command, const std::string& state_folder);
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  pid_t pid() const { return pid_; }
  const std::string& log_path() const { return log_path_; }
  bool is_running();
  /// Of one that has ended, where it is one of ours; else `environment`.
  base::ExitCode exit_code() const;
  /// The last lines that were written to the log since the start.
  std::vector<std::string> log_lines(std::size_t count_max) const;

 private:
  std::string log_path_;
  std::uint64_t log_began_ = 0;  ///< size of the log at the start
  pid_t pid_ = -1;
  bool has_ended_ = false;
  int status_ = 0;
};

}  // namespace sleight::service_client
