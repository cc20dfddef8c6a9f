// Work that is divided among threads, and fails as one.
#pragma once

#include <cstddef>
#include <functional>

namespace sleight::browse {

/// Calls `work` with stretches [first, end) that together are 0 .. count, each once, on so many
/// threads (the caller's among them). Throws what one of them threw, once all have ended.
void for_each_block(std::size_t count, std::size_t threads,
                    const std::function<void(std::size_t first, std::size_t end)>& work);

}  // namespace sleight::browse
