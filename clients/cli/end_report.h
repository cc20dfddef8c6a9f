// Tells a supervisor through a pipe how this process's session ended (--end-report).
//
// The supervisor creates a named pipe (mkfifo), opens it for reading and passes its path to the
// program. A path is needed, because ranks under mpirun don't inherit descriptors. Rank 0 writes
// one line (common/events/run_end.h), even if the session was refused or its disk is full. If a
// check fails on a rank, that rank writes the line if it can see the pipe. If no line was written,
// the session died or never began (--help, --print-request, or an invalid command line with exit
// code 2).
//
// The line describes how the run ended. If the program can't print its summary after writing the
// line, the exit code is still 5.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "common/events/run_end.h"

namespace sleight::cli {

/// One per process. Failed checks are reported while an EndReport exists.
class EndReport {
 public:
  /// How to treat a pipe that doesn't exist or has no reader.
  enum class Missing { is_an_error, tells_nothing };
  /// Opens a pipe or an existing file. Appends to a file. Empty path: reports nothing. Throws
  /// base::Error(usage) if the file is missing and `missing` is is_an_error.
  explicit EndReport(const std::string& path, Missing missing = Missing::is_an_error);
  ~EndReport();
  EndReport(const EndReport&) = delete;
  EndReport& operator=(const EndReport&) = delete;

  /// Writes the line. Only the first call counts. Ignores a missing reader.
  void tell(const events::RunEnd& end);

  /// Runs `work`, which returns an exit code. Reports an exception or a nonzero code, unless `work`
  /// has already reported its end. Rethrows exceptions.
  int watch(const std::function<int()>& work);

 private:
  static void tell_bug(void* self, const std::string& place, const std::string& words);

  int descriptor_ = -1;
  std::atomic<bool> has_told_ = false;
};

}  // namespace sleight::cli
