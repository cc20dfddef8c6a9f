// How a run goes, on stderr: one line that renews itself on a terminal, plain lines elsewhere.
#pragma once

#include <cstdio>
#include <string>

#include "common/events/progress.h"

namespace sleight::cli {

/// A plain line every so often when the output is no terminal.
inline constexpr double k_plain_line_every_s = 5;

/// Writes to a stream (stderr in programs). Not thread-safe.
class ProgressPrinter {
 public:
  ProgressPrinter(std::string name, std::FILE* stream);
  void show(const events::Progress& progress);
  /// What goes on where there is nothing to count; on a terminal only.
  void say(const std::string& phase);
  /// Takes the renewed line away, so that another line can take its place.
  void clear();
  /// Ends the renewed line, so that what follows begins on a new one.
  void finish();

 private:
  void renew(const std::string& line);

  std::string name_;
  std::FILE* stream_;
  bool terminal_;
  bool line_open_ = false;
  double shown_s_ = 0;
  bool said_found_ = false;
};

}  // namespace sleight::cli
