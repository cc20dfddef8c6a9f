// How a run goes, for people: one line that renews itself on a terminal, plain lines elsewhere.
#pragma once

#include <cstdio>
#include <string>

#include "service/coordinator/drive.h"

namespace sleight::coordinator {

/// A plain line every so often when the output is no terminal.
inline constexpr double k_plain_line_every_s = 5;

/// "ball_2d  12,400 of 40,000 scans (31%)  0:04 left  85,200 sims/s  solutions 4  round trips 12
/// satisfied 6,448 (52%)  accepted 41%  2 workers", in one line, what matters most first: a
/// terminal may show its beginning alone.
std::string progress_line(const std::string& name, const Progress& progress);

/// 1234567 as "1,234,567".
std::string grouped(std::uint64_t count);

/// Seconds as "0:04", "12:30" or "3:05:00".
std::string clock_time(double seconds);

/// Writes to a stream (stderr in programs). Not thread-safe.
class ProgressPrinter {
 public:
  ProgressPrinter(std::string name, std::FILE* stream);
  void show(const Progress& progress);
  /// What goes on where there is nothing to count; on a terminal only.
  void say(const std::string& phase);
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

}  // namespace sleight::coordinator
