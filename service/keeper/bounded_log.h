// Stores the output of an attempt's program in files of the job's folder. Their size is bounded.
//
// When `log` reaches half the bound, it is renamed to `log.old`. All attempts of a job append to
// the same files. A marked line begins each attempt and each message of the keeper.
//
// If the disk is full, output is lost but the program continues. The log reports lost bytes later.
//
// Thread safety: one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

namespace sleight::keeper {

inline constexpr std::uint64_t k_log_bytes_max = 8U << 20U;
/// Prefix of the keeper's own lines.
inline constexpr const char* k_log_mark = "=== ";

class BoundedLog {
 public:
  explicit BoundedLog(std::string folder, std::uint64_t bytes_max = k_log_bytes_max);
  ~BoundedLog();
  BoundedLog(const BoundedLog&) = delete;
  BoundedLog& operator=(const BoundedLog&) = delete;

  /// Appends a piece of output. The piece may begin and end within a line.
  void append(std::string_view bytes);
  /// Appends a marked line.
  void mark(std::string_view words);

 private:
  void open();
  void turn_over();
  /// Returns how many of the bytes were written.
  std::size_t write(std::string_view bytes);

  std::string folder_;
  std::uint64_t bytes_max_;
  int descriptor_ = -1;
  std::uint64_t bytes_ = 0;  ///< in `log`
  std::uint64_t lost_ = 0;
  bool at_line_begin_ = true;
};

/// Collects the last lines of an output and cuts each to a maximum length. The last line may be
/// incomplete.
class LastLines {
 public:
  static constexpr std::size_t k_line_bytes_max = 400;

  explicit LastLines(std::size_t lines_max) : lines_max_(lines_max) {}
  void append(std::string_view bytes);
  std::vector<std::string> lines() const;

 private:
  std::size_t lines_max_;
  std::deque<std::string> lines_{};  ///< complete ones
  std::string open_{};               ///< incomplete so far
};

}  // namespace sleight::keeper
