#include "common/base/huge_pages.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace sleight::base {

void prefer_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  ::madvise(memory, bytes, MADV_HUGEPAGE);
#endif
}

}  // namespace sleight::base
