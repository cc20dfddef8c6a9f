#include "service/coordinator/failure_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "common/failure_file/failure_file.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::coordinator {
namespace {

class FailureFilesOf : public archive::testing::Scratch {
 protected:
  static plan::FailedSimulation failed(std::uint64_t scan, std::byte state = std::byte{1}) {
    return {.scan = base::ScanIndex{scan},
            .failure = {.kind = plan::FailureKind::work_limit, .message = "m", .state = {state}}};
  }
  FailureFiles new_files() { return {folder(), "[world]\nname = \"x\"\n", files_}; }
  std::string folder() { return path("run"); }
  std::size_t count() {
    std::size_t count = 0;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder() + "/failures", none))
      count += entry.is_regular_file() ? 1U : 0U;
    return count;
  }
  void SetUp() override {
    Scratch::SetUp();
    std::filesystem::create_directory(folder());
  }
  const plan::ReplicaKey replica_{base::ChainId{1}, base::ReplicaId{2}};
  base::PosixFileSystem files_;
};

TEST_F(FailureFilesOf, KeepAFewThatCanBeReadBack) {
  // Goal: a run's first ten failures are written to files, which can be read back. Later failures
  // are not written.
  FailureFiles keeper = new_files();
  EXPECT_EQ(count(), 0U);
  std::set<std::string> paths;
  for (std::uint64_t scan = 0; scan < 20; ++scan) {
    const auto path = keeper.keep(replica_, failed(scan));
    EXPECT_EQ(path.has_value(), scan < k_failure_files_max);
    if (!path) continue;
    paths.insert(*path);
    const auto back = failure_file::read(base::read_text_file(*path, 1U << 20U), *path);
    ASSERT_TRUE(back.ok()) << request::to_string(back.error());
    EXPECT_EQ(back.value().failed, failed(scan));
  }
  EXPECT_EQ(paths.size(), k_failure_files_max);
  EXPECT_EQ(count(), k_failure_files_max);
}

TEST_F(FailureFilesOf, AreWrittenOnceOverSessions) {
  // Goal: if a lost result is computed again, its failures are not written a second time. A later
  // session adds files up to the limit of ten. Method: report the same failures to two objects.
  {
    FailureFiles first = new_files();
    for (const std::byte state : {std::byte{1}, std::byte{2}, std::byte{3}})
      EXPECT_TRUE(first.keep(replica_, failed(4, state)));
    EXPECT_EQ(count(), 3U);
  }
  FailureFiles second = new_files();
  for (const std::byte state : {std::byte{1}, std::byte{2}, std::byte{3}})
    EXPECT_TRUE(second.keep(replica_, failed(4, state)));
  EXPECT_EQ(count(), 3U);
  for (std::uint64_t scan = 5; scan < 30; ++scan)
    second.keep(replica_, failed(scan));
  EXPECT_EQ(count(), k_failure_files_max);
  FailureFiles::remove_all(folder(), files_);
  EXPECT_EQ(count(), 0U);
  EXPECT_TRUE(new_files().keep(replica_, failed(4)));
}

}  // namespace
}  // namespace sleight::coordinator
