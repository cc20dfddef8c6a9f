#include "common/base/memory.h"

#include <sys/mman.h>

#include <new>

namespace sleight::base {

void require_memory(std::size_t bytes) {
  void* const trial = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (trial == MAP_FAILED) throw std::bad_alloc();
  ::munmap(trial, bytes);
}

}  // namespace sleight::base
