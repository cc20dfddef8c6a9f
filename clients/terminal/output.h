// Prints results reliably: a full disk or a closed stdout must be an error.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <thread>

#include "common/base/error.h"

namespace sleight::terminal {

inline constexpr int k_ok = static_cast<int>(base::ExitCode::ok);

[[noreturn]] void refuse_usage(const std::string& words);

/// Flushes stdout. Throws base::Error(environment) if this flush or an earlier print failed.
void flush_stdout();

/// Runs `work`, which prints to stdout, then calls flush_stdout(). Returns the result of `work`. A
/// failed print in `work` also becomes base::Error(environment).
int with_results(const std::function<int()>& work);

/// Writes a line to stderr. A failed write doesn't change the exit code. Control characters become
/// '?', because other people choose names of files and bodies.
void complain(std::string line);

/// Returns text on one line without control characters, cut after 1,000 characters.
std::string shown(std::string_view text);
/// Returns text of several lines as one line, like shown().
std::string shown_on_one_line(std::string text);

/// While this object exists, the process ends as if by SIGPIPE when its standard output has no
/// reader, even if the process has nothing to write: `sleight watch 17 | head -1`.
class EndsWithItsReader {
 public:
  EndsWithItsReader();
  ~EndsWithItsReader();
  EndsWithItsReader(const EndsWithItsReader&) = delete;
  EndsWithItsReader& operator=(const EndsWithItsReader&) = delete;

 private:
  int over_;  ///< an eventfd; -1: none, and nothing is observed
  std::thread look_;
};

/// Opens the standard streams that the caller closed, so that no other file gets their descriptor
/// numbers. Writing to these streams still fails. Makes writes beyond a file size limit fail,
/// instead of ending the process. Call occupy_standard_streams first in main.
void occupy_standard_streams();

/// Throws base::Error(usage) if writing `output` would replace `archive`, even through another path
/// or link.
void refuse_same_file(const std::string& archive, const std::string& output);

}  // namespace sleight::terminal
