// Goal: an index that is stored between commands is used only for its own archive. If several
// archives contain an animation, it counts once. All given queries are applied. Method: store
// indexes of made-up animations in a scratch folder, then change or truncate them.
#include "clients/browse/archives/browsed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "clients/browse/archives/index_cache.h"
#include "common/base/error.h"
#include "tests/unit/clients/browse/random_index.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::browse {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class IndexCache : public archive::testing::Scratch {
 protected:
  void SetUp() override {
    ::setenv("XDG_CACHE_HOME", path("cache").c_str(), 1);
    archive_ = path("a.h5");
    std::ofstream(archive_) << "an archive";
  }
  void TearDown() override { ::unsetenv("XDG_CACHE_HOME"); }

  static browse::Index large() {
    random::Stream stream({.seed = 1, .purpose = random::Purpose::prior}, 0);
    browse::Index index = browse::testing::random_index(4, stream);
    browse::Entry& long_one = index.entries.front();
    while (long_one.pieces.size() < k_pieces_worth_keeping)
      long_one.pieces.push_back(long_one.pieces.back());
    long_one.tracks.back().count =
        static_cast<std::uint32_t>(long_one.pieces.size()) - long_one.tracks.back().first;
    return index;
  }
  fs::path kept_file() const {
    for (const auto& file : fs::directory_iterator(path("cache/sleight/browse"))) {
      if (file.path().extension() == ".index") return file.path();
    }
    return {};
  }

  std::string archive_;
};

TEST_F(IndexCache, GivesBackWhatItKept) {
  EXPECT_FALSE(kept_index(archive_).has_value());
  const browse::Index index = large();
  keep_index(archive_, *state_of_file(archive_), index);
  const auto kept = kept_index(archive_);
  ASSERT_TRUE(kept.has_value());
  EXPECT_EQ(kept->index.digest, index.digest);
  ASSERT_EQ(kept->index.entries.size(), index.entries.size());
  for (std::size_t i = 0; i < index.entries.size(); ++i)
    EXPECT_TRUE(kept->index.entries[i] == index.entries[i]);
  EXPECT_TRUE(kept->of == *state_of_file(archive_));
  // The stored index is found through a link to its archive, but not for another archive.
  fs::create_symlink(archive_, path("link.h5"));
  EXPECT_TRUE(kept_index(path("link.h5")).has_value());
  std::ofstream(path("b.h5")) << "another";
  EXPECT_FALSE(kept_index(path("b.h5")).has_value());
  struct stat status {};
  ASSERT_EQ(::stat(kept_file().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  ASSERT_EQ(::stat(kept_file().parent_path().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0700U);
}

TEST_F(IndexCache, KeepsOutlinesOfOneStateOfTheFile) {
  const browse::Index index = large();
  const browse::Groups groups{.groups = {{.representative = 1, .members = {0, 1, 2, 3}}}};
  const FileState now = *state_of_file(archive_);
  EXPECT_FALSE(kept_outline(archive_, now).has_value());
  keep_outline(archive_, now, index, groups);
  const auto kept = kept_outline(archive_, now);
  ASSERT_TRUE(kept.has_value());
  EXPECT_EQ(kept->index.entries.size(), 4U);
  EXPECT_EQ(kept->groups.groups[0].members.size(), 4U);
  EXPECT_FALSE(kept_index(archive_).has_value());
  FileState later = now;
  ++later.modified_ns;
  EXPECT_FALSE(kept_outline(archive_, later).has_value());
}

TEST_F(IndexCache, ForgetsWhatWasChanged) {
  keep_index(archive_, *state_of_file(archive_), large());
  const fs::path file = kept_file();
  fs::resize_file(file, fs::file_size(file) - 1);
  EXPECT_FALSE(kept_index(archive_).has_value());
  std::ofstream(file) << "nothing of ours";
  EXPECT_FALSE(kept_index(archive_).has_value());
  keep_index(archive_, *state_of_file(archive_), large());
  EXPECT_TRUE(kept_index(archive_).has_value());
}

TEST_F(IndexCache, NoticesThatTheArchiveWasChanged) {
  const FileState before = *state_of_file(archive_);
  std::fstream(archive_, std::ios::in | std::ios::out) << "AN";  // as long as before
  EXPECT_FALSE(before == *state_of_file(archive_));
  EXPECT_FALSE(state_of_file(path("none.h5")).has_value());
}

TEST_F(IndexCache, TakesAwayWhatAKilledProgramLeft) {
  keep_index(archive_, *state_of_file(archive_), large());
  const fs::path left = kept_file().string() + ".tmp.abcdef";
  const fs::path fresh = kept_file().string() + ".tmp.ghijkl";
  std::ofstream(left) << "left behind";
  std::ofstream(fresh) << "being written";
  fs::last_write_time(left, fs::file_time_type::clock::now() - std::chrono::hours(2));
  keep_index(archive_, *state_of_file(archive_), large());
  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(fs::exists(fresh));
  EXPECT_TRUE(kept_index(archive_).has_value());
}

TEST_F(IndexCache, DoesWithoutWhereItCannotWrite) {
  std::ofstream(path("cache")) << "a file in its place";
  keep_index(archive_, *state_of_file(archive_), large());
  EXPECT_FALSE(kept_index(archive_).has_value());
  ::setenv("XDG_CACHE_HOME", "relative", 1);
  ::setenv("HOME", path("").c_str(), 1);
  keep_index(archive_, *state_of_file(archive_), large());
  EXPECT_TRUE(fs::exists(path(".cache/sleight/browse")));
  EXPECT_FALSE(fs::exists("relative"));
}

TEST_F(IndexCache, KeepsNothingSmall) {
  random::Stream stream({.seed = 1, .purpose = random::Purpose::prior}, 1);
  keep_index(archive_, *state_of_file(archive_), browse::testing::random_index(3, stream));
  EXPECT_FALSE(kept_index(archive_).has_value());
}

Browsed two_archives() {
  random::Stream stream({.seed = 1, .purpose = random::Purpose::prior}, 2);
  Browsed browsed;
  browsed.archives.push_back({.path = "a.h5", .index = browse::testing::random_index(3, stream)});
  browsed.archives.push_back({.path = "b.h5", .index = browse::testing::random_index(5, stream)});
  return browsed;
}

TEST(BrowsedArchives, CountEachAnimationOnce) {
  Browsed browsed = two_archives();
  leave_out_twice(browsed);
  EXPECT_EQ(browsed.animations(), 5U);
  EXPECT_EQ(browsed.archives[0].twice, 0U);
  EXPECT_EQ(browsed.archives[1].twice, 3U);
  EXPECT_EQ(name_among(browsed, browsed.archives[1].index.entries[0].name), "c0.3");
  browsed.archives[1].index.run_id = "another";
  EXPECT_EQ(name_among(browsed, browsed.archives[1].index.entries[0].name), "run:c0.3");
}

TEST(BrowsedArchives, AnswerAllQueriesThatAreGiven) {
  Browsed browsed = two_archives();
  EXPECT_EQ(picked(browsed, {}).size(), 8U);
  const auto found =
      picked(browsed, {.where = {"draw > 0"}, .in = {"draw < 3"}, .not_in = {"draw = 1"}});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].archive->path, "a.h5");
  EXPECT_EQ(found[1].entry->name.draw, 2U);
  try {
    picked(browsed, {.not_in = {"draw < "}});
    FAIL() << "it is no query";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::usage);
    EXPECT_THAT(error.what(), HasSubstr("--not for a.h5: column 8: expected a number"));
  }
}

}  // namespace
}  // namespace sleight::browse
