// Tells people how far the writing of an archive is: "writing the archive: 1,200 of 5,000 draws
// (24%) 0:12 left 310 draws/s".
//
// The time between messages is at least k_writing_said_every_s. So if a part is short, it may have
// no message. Not thread-safe.
#pragma once

#include <functional>
#include <string>

#include "common/archive/layout.h"
#include "common/base/clock.h"

namespace sleight::coordinator {

inline constexpr const char* k_writing = "writing the archive";
/// Minimum interval between two messages.
inline constexpr double k_writing_said_every_s = 0.5;

class WritingWords {
 public:
  using Say = std::function<void(const std::string&)>;
  /// Borrows the clock.
  WritingWords(Say say, const base::Clock& clock);
  void hear(const archive::WritingProgress& now);

 private:
  Say say_;
  const base::Clock& clock_;
  archive::WritingProgress begun_;  ///< the current part, as first reported
  double begun_s_;
  double said_s_;
};

}  // namespace sleight::coordinator
