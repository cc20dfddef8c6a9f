// Counts a test program's allocations by replacing operator new and delete. Include this header in
// exactly one source file, because the operators belong to the whole program.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace sleight::physics::counting {

inline std::uint64_t allocations = 0;

inline void* counted(std::size_t bytes, std::size_t alignment) noexcept {
  ++allocations;
  // aligned_alloc requires whole multiples of the alignment.
  bytes = std::max(bytes, std::size_t{1});
  return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
}

inline void* counted_or_throw(std::size_t bytes, std::size_t alignment) {
  if (void* memory = counted(bytes, alignment)) return memory;
  throw std::bad_alloc();
}

}  // namespace sleight::physics::counting

// Not inlined; otherwise, the compiler would see `new` without its `delete` and warn.
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  return sleight::physics::counting::counted_or_throw(bytes, alignof(std::max_align_t));
}
[[gnu::noinline]] void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return sleight::physics::counting::counted_or_throw(bytes, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return sleight::physics::counting::counted(bytes, alignof(std::max_align_t));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
