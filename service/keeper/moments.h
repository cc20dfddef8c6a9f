// The moments of a keeper's life at which tests kill it.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace sleight::keeper {

/// In this order. Each lies between two effects that others see.
enum class Moment : std::uint8_t {
  begun,          ///< nothing is done
  locked,         ///< it has the folder's lock
  prepared,       ///< pipe and log are there, what an earlier attempt left is gone
  recorded,       ///< the beginning is durable
  in_child,       ///< forked; reached in the child, which has not called exec
  forked,         ///< the same, in the keeper
  started,        ///< the program runs
  program_ended,  ///< its descendants may run
  alone,          ///< none runs
  end_recorded    ///< the end is durable
};

inline constexpr std::array<std::string_view, 10> k_moment_names{
    "begun",  "locked",  "prepared",      "recorded", "in_child",
    "forked", "started", "program_ended", "alone",    "end_recorded"};

/// A real keeper does nothing at them.
class Moments {
 public:
  virtual ~Moments() = default;
  virtual void reached(Moment /*moment*/) {}
};

}  // namespace sleight::keeper
