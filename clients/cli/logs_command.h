// `sleight logs`: prints the end of a job's log, or follows it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sleight::cli {

struct LogsOptions {
  std::string job{};
  bool follow = false;  ///< until the job ends or Ctrl-C
  std::uint32_t lines = 50;
  bool json = false;
};

int show_logs(const std::string& socket, const LogsOptions& options);

/// Splits bytes of a log into lines that are safe for a terminal.
class LogLines {
 public:
  /// Appends bytes and returns the complete lines with their line ends. If a line is longer than
  /// k_line_bytes_max, it is returned in parts.
  std::string add(std::string_view bytes);
  /// Returns the incomplete last line.
  std::string rest();

  static constexpr std::size_t k_line_bytes_max = 64U << 10U;

 private:
  std::string open_;
};

}  // namespace sleight::cli
