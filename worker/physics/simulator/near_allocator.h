// Arrays that events access at random places. The arrays are aligned to cache lines, and large
// arrays are on huge pages.
//
// A simulation of many bodies reads some tens of cache lines per event, from places all over its
// arrays. If pages had 4 KiB, each read would also need a page-table walk. So large arrays request
// huge pages, for kernels that have them but don't use them by default. Thread safety: values.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include "common/base/huge_pages.h"

namespace sleight::physics {

template <class T>
struct NearAllocator {
  using value_type = T;
  static constexpr std::size_t k_line = 64;

  NearAllocator() = default;
  template <class U>
  NearAllocator(const NearAllocator<U>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    void* const memory = ::operator new(bytes, alignment(bytes));
    if (bytes >= base::k_huge_page_bytes) base::prefer_huge_pages(memory, bytes);
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    ::operator delete(memory, alignment(count * sizeof(T)));
  }
  friend bool operator==(NearAllocator, NearAllocator) { return true; }

 private:
  static std::align_val_t alignment(std::size_t bytes) {
    return std::align_val_t{bytes >= base::k_huge_page_bytes ? base::k_huge_page_bytes : k_line};
  }
};

template <class T>
using NearVector = std::vector<T, NearAllocator<T>>;

}  // namespace sleight::physics
