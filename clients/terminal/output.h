// Results that reach their place, or an error that says so: a full disk or a closed stdout must not
// look like success.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <thread>

#include "common/base/error.h"

namespace sleight::terminal {

inline constexpr int k_ok = static_cast<int>(base::ExitCode::ok);

/// Throws base::Error(usage).
[[noreturn]] void refuse_usage(const std::string& words);

/// Writes out what waits for stdout. Throws base::Error(environment) when that, or any earlier
/// print, failed.
void flush_stdout();

/// Runs `work`, which prints to stdout, then flush_stdout; returns what `work` returns. Failed
/// prints inside `work` become the same base::Error(environment).
int with_results(const std::function<int()>& work);

/// Writes a line to stderr; if that is lost, the exit code still tells. Control characters become
/// '?', since other people write names of files and of an archive's bodies.
void complain(std::string line);

/// Text on one line, without control characters; a longer one than 1,000 characters is cut.
std::string shown(std::string_view text);
/// The same of text that may have several lines: they become one.
std::string shown_on_one_line(std::string text);

/// While it lives, this process ends as SIGPIPE would end it as soon as nobody reads its standard
/// output any more, also while it has nothing to write: `sleight watch 17 | head -1`.
class EndsWithItsReader {
 public:
  EndsWithItsReader();
  ~EndsWithItsReader();
  EndsWithItsReader(const EndsWithItsReader&) = delete;
  EndsWithItsReader& operator=(const EndsWithItsReader&) = delete;

 private:
  int over_;  ///< an eventfd; -1: there is none, and nothing is looked at
  std::thread look_;
};

/// Opens the standard streams that the caller closed, so that writing to them still fails, but no
/// file or pipe of ours takes their place; and a limit on the size of files fails a write like a
/// full disk, instead of ending the process. Called first of all.
void occupy_standard_streams();

/// Throws base::Error(usage) when writing `output` would replace `archive`: the same file by
/// whatever path or link.
void refuse_same_file(const std::string& archive, const std::string& output);

}  // namespace sleight::terminal
