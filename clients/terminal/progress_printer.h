// Prints a run's progress to stderr: one updated line on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

#include "clients/terminal/terminal.h"
#include "common/events/progress.h"

namespace sleight::terminal {

/// Interval of plain lines if the output isn't a terminal.
inline constexpr double k_plain_line_every_s = 5;

class ProgressPrinter {
 public:
  ProgressPrinter(std::string name, std::FILE* stream,
                  double plain_line_every_s = k_plain_line_every_s);
  void show(const events::Progress& progress);
  /// Shows what the program does while there are no scans to count. Without a terminal, only long
  /// phases are shown.
  void say(const std::string& phase);
  /// Removes the updated line, so that another line can replace it.
  void clear() { line_.clear(); }
  /// Ends the updated line, so that further output begins on a new line.
  void finish() { line_.finish(); }

 private:
  void put_plain(const std::string& line);

  std::string name_;
  std::FILE* stream_;
  RenewedLine line_;
  double plain_line_every_s_;
  std::chrono::steady_clock::time_point plain_line_at_;  ///< of the last one, or the start
  double shown_s_ = 0;
  bool said_found_ = false;
};

}  // namespace sleight::terminal
