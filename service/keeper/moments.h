// Moments in a keeper's life at which tests kill the keeper.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace sleight::keeper {

/// Moments in order. Each moment lies between two effects that other processes can see.
enum class Moment : std::uint8_t {
  begun,          ///< nothing done yet
  locked,         ///< the keeper has the folder's lock
  prepared,       ///< pipe and log exist; remains of earlier attempts are removed
  recorded,       ///< the beginning is durable
  in_child,       ///< forked; reached in the child before exec
  forked,         ///< forked; reached in the keeper
  started,        ///< the program runs
  program_ended,  ///< its descendants may still run
  alone,          ///< no descendant runs
  end_recorded    ///< the end is durable
};

inline constexpr std::array<std::string_view, 10> k_moment_names{
    "begun",  "locked",  "prepared",      "recorded", "in_child",
    "forked", "started", "program_ended", "alone",    "end_recorded"};

/// Called at each moment. A real keeper does nothing at these moments.
class Moments {
 public:
  virtual ~Moments() = default;
  virtual void reached(Moment /*moment*/) {}
};

}  // namespace sleight::keeper
