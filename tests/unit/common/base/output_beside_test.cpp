#include "common/base/output_beside.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <ostream>
#include <stdexcept>

#include "common/base/error.h"
#include "common/base/file_system.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::base {
namespace {

namespace fs = std::filesystem;

class Outputs : public archive::testing::Scratch {
 protected:
  void write(const std::string& name, const std::string& text) const {
    write_output(path(name), [&](std::ostream& file) { file << text; });
  }
  std::string text_of(const std::string& name) const { return read_text_file(path(name), 100); }
};

TEST_F(Outputs, GoWhereLinksLead) {
  // Goal: if an output's path is a link, the link's target is written, and the link stays. The
  // target need not exist before. If the link is circular, the write fails.
  fs::create_directory(path("real"));
  fs::create_symlink("real/a", path("near"));
  fs::create_symlink(path("near"), path("far"));
  for (const char* text : {"one", "two"}) {
    write("far", text);
    EXPECT_EQ(text_of("real/a"), text);
  }
  EXPECT_EQ(fs::read_symlink(path("near")), "real/a");
  EXPECT_EQ(fs::read_symlink(path("far")), path("near"));
  EXPECT_EQ(where_links_lead(path("far")), path("real/a"));
  EXPECT_EQ(where_links_lead("a.h5"), "a.h5");
  fs::create_symlink("real", path("folder"));
  EXPECT_EQ(where_links_lead(path("folder") + "//"), path("real"));
  fs::create_symlink("circle", path("circle"));
  EXPECT_THROW(write("circle", "x"), Error);
}

TEST_F(Outputs, AreWholeOrAsBefore) {
  // Goal: if a write fails, the old file stays, and no other file is left. The mode of a new file
  // follows the umask.
  write("a", "old");
  const auto throwing = [](std::ostream& file) {
    file << "new";
    throw std::runtime_error("stopped");
  };
  EXPECT_THROW(write_output(path("a"), throwing), std::runtime_error);
  EXPECT_EQ(text_of("a"), "old");
  EXPECT_THROW(write("none/a", "x"), Error);
  if (fs::exists("/dev/full")) {
    fs::create_symlink("/dev/full", path("full"));
    EXPECT_THROW(write("full", "x"), Error);
    EXPECT_TRUE(fs::is_symlink(path("full")));
    fs::remove(path("full"));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(path("")), fs::directory_iterator()), 1);
  for (const mode_t umask : {S_IWOTH, S_IWGRP | S_IWOTH}) {
    const mode_t before = ::umask(umask);
    write("a", "new");
    ::umask(before);
    struct stat about {};
    ASSERT_EQ(::stat(path("a").c_str(), &about), 0);
    EXPECT_EQ(about.st_mode & 0777U, 0666U & ~umask);
  }
}

}  // namespace
}  // namespace sleight::base
