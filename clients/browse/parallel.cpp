#include "clients/browse/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace sleight::browse {

void for_each_block(std::size_t count, std::size_t threads,
                    const std::function<void(std::size_t, std::size_t)>& work) {
  threads = std::max<std::size_t>(threads, 1);
  // Use small blocks, because the blocks' costs differ.
  constexpr std::size_t k_blocks_of_thread = 16;
  const std::size_t size = std::max<std::size_t>(1, count / (threads * k_blocks_of_thread));
  std::atomic<std::size_t> next{0};
  // Any thread may run out of memory; the caller rethrows the exception.
  std::vector<std::exception_ptr> failures(threads);
  const auto run = [&](std::size_t thread) {
    try {
      for (std::size_t first = next.fetch_add(size); first < count; first = next.fetch_add(size))
        work(first, std::min(first + size, count));
    } catch (...) {
      failures[thread] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t thread = 1; thread < threads; ++thread)
      others.emplace_back(run, thread);
    run(0);
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

}  // namespace sleight::browse
