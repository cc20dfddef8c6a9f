// `sleight logs`: what a job's program wrote, its last lines or as it grows.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sleight::cli {

struct LogsOptions {
  std::string job{};
  bool follow = false;  ///< until the job has ended, or Ctrl-C
  std::uint32_t lines = 50;
  bool json = false;
};

int show_logs(const std::string& socket, const LogsOptions& options);

/// Bytes of a log, cut anywhere, as lines that are fit for a terminal. A value.
class LogLines {
 public:
  /// The lines that are whole by now, each with its end; a line beyond k_line_bytes_max comes in
  /// parts.
  std::string add(std::string_view bytes);
  /// What is left, as a line.
  std::string rest();

  static constexpr std::size_t k_line_bytes_max = 64U << 10U;

 private:
  std::string open_;
};

}  // namespace sleight::cli
