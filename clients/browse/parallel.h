// Divides work among threads.
#pragma once

#include <cstddef>
#include <functional>

namespace sleight::browse {

/// Calls `work` with disjoint blocks [first, end) that cover 0 .. count, on this many threads
/// including the caller's. After all blocks have ended, rethrows an exception of one block.
void for_each_block(std::size_t count, std::size_t threads,
                    const std::function<void(std::size_t first, std::size_t end)>& work);

}  // namespace sleight::browse
