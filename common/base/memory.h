// Handles lack of memory.
#pragma once

#include <cstddef>

namespace sleight::base {

/// Error message for people, printed after the program's name.
inline constexpr const char* k_too_little_memory =
    "too little memory; raise any memory limit that is set (ulimit -v, or a job's memory)";

/// Throws std::bad_alloc if this process can't allocate `bytes` more. Call this before library
/// functions that crash if memory is short.
void require_memory(std::size_t bytes);

}  // namespace sleight::base
