// Goal: once a save is durable, its callback `then` is called. Callbacks are called in the order of
// the put() calls. Method: put many saves from one thread. Each callback checks that the store has
// the save's job.
#include "service/daemon/save_queue.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <future>

#include "tests/unit/service/daemon/example_jobs.h"

namespace sleight::daemon {
namespace {

TEST(SaveQueue, ThenComesAfterTheDisk) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("save-queue-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const std::string path = folder / "jobs.sqlite";
  constexpr std::uint64_t k_saves = 300;
  std::vector<std::uint64_t> heard;
  std::promise<void> all;
  {
    JobStore store(path);
    JobReader reader(store.to_read());
    SaveQueue queue(
        std::move(store), [](const SaveQueue::Callback& callback) { callback(); },
        [](const std::string& reason) { ADD_FAILURE() << reason; });
    for (std::uint64_t id = 1; id <= k_saves; ++id) {
      Save save;
      save.jobs.jobs.push_back(testing::full_job(id));
      save.requests.push_back({.job = jobs::JobId{id}, .text = "text"});
      save.jobs.next_id = id + 1;
      // Every tenth entry has nothing to save but keeps its place in the queue.
      const bool is_empty = id % 10 == 0;
      queue.put(is_empty ? std::nullopt : std::optional(save), [&, id, is_empty] {
        heard.push_back(id);
        if (!is_empty) {
          EXPECT_TRUE(reader.request(jobs::JobId{id}, 1).has_value());
        }
        if (id == k_saves) all.set_value();
      });
    }
    all.get_future().wait();
  }
  ASSERT_EQ(heard.size(), k_saves);
  for (std::uint64_t i = 0; i < k_saves; ++i)
    EXPECT_EQ(heard[i], i + 1);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace sleight::daemon
