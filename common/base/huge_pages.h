// Huge pages for big arrays, as a hint to the operating system.
#pragma once

#include <cstddef>

namespace sleight::base {

/// Smaller arrays don't benefit from huge pages.
inline constexpr std::size_t k_huge_page_bytes = std::size_t{1} << 21U;

/// Requests huge pages for `memory`. If the system does not support them, pages stay small.
/// REQUIRES: `memory` is aligned to k_huge_page_bytes. Thread-safe.
void prefer_huge_pages(void* memory, std::size_t bytes);

}  // namespace sleight::base
