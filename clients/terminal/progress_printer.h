// How a run goes, on stderr: one line that renews itself on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

#include "clients/terminal/terminal.h"
#include "common/events/progress.h"

namespace sleight::terminal {

/// A plain line every so often when the output is no terminal.
inline constexpr double k_plain_line_every_s = 5;

/// Writes to a stream (stderr in programs). Not thread-safe.
class ProgressPrinter {
 public:
  ProgressPrinter(std::string name, std::FILE* stream,
                  double plain_line_every_s = k_plain_line_every_s);
  void show(const events::Progress& progress);
  /// What goes on where there are no scans to count: elsewhere than on a terminal too if it lasts.
  void say(const std::string& phase);
  /// Takes the renewed line away, so that another line can take its place.
  void clear() { line_.clear(); }
  /// Ends the renewed line, so that what follows begins on a new one.
  void finish() { line_.finish(); }

 private:
  void put_plain(const std::string& line);

  std::string name_;
  std::FILE* stream_;
  RenewedLine line_;
  double plain_line_every_s_;
  std::chrono::steady_clock::time_point plain_line_at_;  ///< the last; at first the beginning
  double shown_s_ = 0;
  bool said_found_ = false;
};

}  // namespace sleight::terminal
