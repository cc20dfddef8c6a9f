// What an attempt's program prints, in files of the job's folder that never grow over a bound.
//
// `log`, and before it `log.old`: when the first is full, at half the bound, it takes the place of
// the second. All attempts of a job go on in the same files; each begins with a marked line, as
// does whatever the keeper has to say.
//
// A disk that takes nothing loses output, never stops a program: the log says how much was lost
// once it can.
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
/// A line of the keeper's own begins so.
inline constexpr const char* k_log_mark = "=== ";

class BoundedLog {
 public:
  explicit BoundedLog(std::string folder, std::uint64_t bytes_max = k_log_bytes_max);
  ~BoundedLog();
  BoundedLog(const BoundedLog&) = delete;
  BoundedLog& operator=(const BoundedLog&) = delete;

  /// What a program printed, in any pieces.
  void append(std::string_view bytes);
  /// A marked line, on a line of its own.
  void mark(std::string_view words);

 private:
  void open();
  void turn_over();
  /// How many bytes of these the disk took.
  std::size_t write(std::string_view bytes);

  std::string folder_;
  std::uint64_t bytes_max_;
  int descriptor_ = -1;
  std::uint64_t bytes_ = 0;  ///< in `log`
  std::uint64_t lost_ = 0;
  bool at_line_begin_ = true;
};

/// The last lines of what is printed, each cut to a length; the last one may lack its end.
class LastLines {
 public:
  static constexpr std::size_t k_line_bytes_max = 400;

  explicit LastLines(std::size_t lines_max) : lines_max_(lines_max) {}
  void append(std::string_view bytes);
  std::vector<std::string> lines() const;

 private:
  std::size_t lines_max_;
  std::deque<std::string> lines_{};  ///< whole ones
  std::string open_{};               ///< without its end yet
};

}  // namespace sleight::keeper
