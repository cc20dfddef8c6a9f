// Where memory is short.
#pragma once

#include <cstddef>

namespace sleight::base {

/// What people are told, after the program's name.
inline constexpr const char* k_too_little_memory =
    "too little memory; if a limit is set (ulimit -v, or a job's memory), raise it";

/// Throws std::bad_alloc where this process could not have so many bytes more. Before calls of
/// libraries that crash for want of memory.
void require_memory(std::size_t bytes);

}  // namespace sleight::base
