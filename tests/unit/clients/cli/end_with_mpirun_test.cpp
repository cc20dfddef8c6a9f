#include "clients/cli/end_with_mpirun.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/property.h"

namespace sleight::cli {
namespace {

namespace fs = std::filesystem;

/// Maps a file of one page and never unmaps it.
void map_file(const fs::path& path) {
  std::ofstream(path) << std::string(4096, 'x');
  const int file = open(path.c_str(), O_RDONLY);
  ASSERT_GE(file, 0);
  ASSERT_NE(mmap(nullptr, 4096, PROT_READ, MAP_SHARED, file, 0), MAP_FAILED);
  close(file);
}

/// Maps the files that a rank maps, and many other files. Then several threads raise the signal
/// that announces the parent's death.
[[noreturn]] void be_a_rank(const fs::path& folder) {
  for (int i = 0; i < 40; ++i)
    map_file(folder / ("other." + std::to_string(i)));
  map_file(folder / "vader_segment.host.0.1");
  map_file(folder / "not_vader_segment.host");
  end_with_mpirun();
  const pthread_t main_thread = pthread_self();
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([] {
      while (true)
        raise(SIGRTMIN + 7);
    });
  }
  pthread_kill(main_thread, SIGRTMIN + 7);
  while (true)
    pause();
}

TEST(EndWithMpirunDeathTest, TakesItsMemoryAlongAndNothingElse) {
  // Goal: when mpirun dies, a rank removes Open MPI's shared-memory files and no other mapped file,
  // even if several threads get the signal. Method: repeatedly run a process that maps files. The
  // process's threads raise the signal that announces mpirun's death.
  GTEST_FLAG_SET(death_test_style, "fast");
  const fs::path folder = fs::temp_directory_path() / ("sleight-ranks-" + std::to_string(getpid()));
  const fs::path here = fs::read_symlink("/proc/self/exe");
  for (std::uint64_t again = 0; again < property::of_tier(20, 200); ++again) {
    fs::create_directories(folder);
    EXPECT_EXIT(be_a_rank(folder), ::testing::ExitedWithCode(128 + SIGKILL), "");
    EXPECT_FALSE(fs::exists(folder / "vader_segment.host.0.1"));
    EXPECT_TRUE(fs::exists(folder / "not_vader_segment.host"));
    for (int i = 0; i < 40; ++i)
      EXPECT_TRUE(fs::exists(folder / ("other." + std::to_string(i))));
    ASSERT_TRUE(fs::exists(here));
    fs::remove_all(folder);
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace sleight::cli
