// Huge pages for big arrays, as a hint to the operating system.
#pragma once

#include <cstddef>

namespace sleight::base {

/// Arrays of this size and more gain by huge pages.
inline constexpr std::size_t k_huge_page_bytes = std::size_t{1} << 21U;

/// Asks for huge pages behind `memory`; where that is refused or unknown, pages are small.
/// REQUIRES: `memory` lies at a multiple of k_huge_page_bytes. Thread-safe.
void prefer_huge_pages(void* memory, std::size_t bytes);

}  // namespace sleight::base
