// Failures of the environment: a file can't be written, the disk is full, another process holds a
// run's lock.
//
// Errors are caught only in shells (a program's main), which print what() and exit with exit_code.
// The message names the attempted action, what happened and what to do.
#pragma once

#include <stdexcept>
#include <string>

namespace sleight::base {

/// Exit codes of every Sleight program; docs and `sleight --help` list them.
enum class ExitCode : int {
  ok = 0,
  bug = 1,                ///< an unexpected failure of Sleight
  usage = 2,              ///< invalid command line
  bad_request = 3,        ///< errors in the request file, each printed with its place
  conflict = 4,           ///< the output belongs to another request or process
  environment = 5,        ///< disk full, no permission, a missing file
  bad_archive = 6,        ///< not a Sleight archive, damaged, or hostile
  not_mixed = 7,          ///< `sleight diagnose`: the chains have not mixed
  simulation_failed = 8,  ///< with --strict, or if all failed: a bug of the simulator
  not_allowed = 9,        ///< the service: not permitted, or not trusted
  job_failed = 10,        ///< `sleight wait` and `watch`: the job failed
  job_cancelled = 11,     ///< `sleight wait` and `watch`: the job was cancelled
  no_server = 12,         ///< no `sleightd` answers
  interrupted = 130,      ///< Ctrl-C or SIGTERM: completed work is stored
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode exit_code, const std::string& message)
      : std::runtime_error(message), exit_code_(exit_code) {}
  explicit Error(const std::string& message) : Error(ExitCode::environment, message) {}

  ExitCode exit_code() const { return exit_code_; }

 private:
  ExitCode exit_code_;
};

}  // namespace sleight::base
