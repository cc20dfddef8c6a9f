// How this process's session ended, told to a supervisor through a pipe (--end-report).
//
// The supervisor makes a pipe with a name (mkfifo), opens it for reading and starts the program
// with its path: ranks under mpirun inherit no descriptors. One line comes out
// (common/events/run_end.h), of rank 0, also where the session was refused or its disk is full; a
// check that fails is told by the rank that it fails on, where that sees the pipe. No line: the
// session died, or there was none:
// --help, --print-request, a command line that can't be read (exit code 2).
//
// The line says how the run ended. A program that then can't print its summary returns 5 all the
// same.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "common/events/run_end.h"

namespace sleight::cli {

/// One a process: from its construction on checks that fail are told too.
class EndReport {
 public:
  /// What becomes of a pipe that is not there, or that nobody reads.
  enum class Missing { is_an_error, tells_nothing };
  /// Opens a pipe, or a file that is there, to append to. Empty: nothing is told. Throws
  /// base::Error(usage) where it is missing, if that is an error.
  explicit EndReport(const std::string& path, Missing missing = Missing::is_an_error);
  ~EndReport();
  EndReport(const EndReport&) = delete;
  EndReport& operator=(const EndReport&) = delete;

  /// Writes the line; the first counts. A supervisor that has gone is no error.
  void tell(const events::RunEnd& end);

  /// Runs `work`, which returns an exit code. Where that ends by an exception, or by an exit code
  /// other than 0 without having told anything, tells that; exceptions go on.
  int watch(const std::function<int()>& work);

 private:
  static void tell_bug(void* self, const std::string& place, const std::string& words);

  int descriptor_ = -1;
  std::atomic<bool> has_told_ = false;
};

}  // namespace sleight::cli
