#include "common/base/file_system.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <span>
#include <string_view>
#include <utility>

#include "common/base/error.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::base {
namespace {

using ::testing::HasSubstr;

class FileSystemOfPosix : public archive::testing::Scratch {
 protected:
  static std::string failure_of(const std::function<void()>& act) {
    try {
      act();
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code(), ExitCode::environment);
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return {};
  }

  PosixFileSystem files_;
};

TEST_F(FileSystemOfPosix, KnowsWhatExists) {
  // Goal: exists() tells whether a path exists. If the system can't tell, exists() throws an error.
  put_bytes(path("file"), "x");
  EXPECT_TRUE(files_.exists(path("file")));
  EXPECT_TRUE(files_.exists(path("")));
  EXPECT_FALSE(files_.exists(path("nothing")));
  EXPECT_FALSE(files_.exists(path("file/below")));
  const std::string long_name = path(std::string(5000, 'n'));
  EXPECT_THAT(failure_of([&] { (void)files_.exists(long_name); }), HasSubstr(long_name));
}

TEST_F(FileSystemOfPosix, TellsFoldersAndWhatIsInThem) {
  // Goal: folders are distinguished from files, and the names in a folder are sorted. The error
  // about a path that can't be listed contains the path.
  put_bytes(path("b"), "x");
  put_bytes(path("a"), "x");
  std::filesystem::create_directory(path("c"));
  EXPECT_TRUE(files_.is_directory(path("c")));
  EXPECT_FALSE(files_.is_directory(path("a")));
  EXPECT_FALSE(files_.is_directory(path("nothing")));
  EXPECT_FALSE(files_.is_directory(path("a/below")));
  EXPECT_THAT(files_.names_in(path("")), ::testing::ElementsAre("a", "b", "c"));
  EXPECT_THAT(files_.names_in(path("c")), ::testing::IsEmpty());
  EXPECT_THAT(failure_of([&] { (void)files_.names_in(path("a")); }),
              AllOf(HasSubstr(path("a")), HasSubstr("Not a directory")));
}

TEST_F(FileSystemOfPosix, WritesAndReadsAtAnyPlace) {
  // Goal: bytes are read at the offsets where they were written. Bytes that were never written are
  // zero. Creating an existing file empties the file.
  const auto bytes = [](std::string_view text) { return std::as_bytes(std::span(text)); };
  auto file = std::move(files_.create(path("file"))).value();
  EXPECT_FALSE(file->write_at(3, bytes("defg")));
  EXPECT_FALSE(file->write_at(0, bytes("a")));
  std::string read(9, '?');
  EXPECT_FALSE(file->read_at(0, std::as_writable_bytes(std::span(read))));
  EXPECT_EQ(read, std::string("a\0\0defg\0\0", 9));
  EXPECT_FALSE(file->resize(5));
  EXPECT_FALSE(file->close());
  EXPECT_EQ(bytes_of(path("file")), std::string("a\0\0de", 5));
  ASSERT_TRUE(files_.create(path("file")).ok());
  EXPECT_EQ(bytes_of(path("file")), "");
}

TEST_F(FileSystemOfPosix, CreatesNothingThroughALink) {
  // Goal: if the new file's path is a link, create() doesn't follow the link. create() returns the
  // system's errors.
  put_bytes(path("target"), "kept");
  std::filesystem::create_symlink(path("target"), path("link"));
  EXPECT_EQ(files_.create(path("link")).error(), std::errc::too_many_symbolic_link_levels);
  EXPECT_EQ(bytes_of(path("target")), "kept");
  EXPECT_EQ(files_.create(path("none/file")).error(), std::errc::no_such_file_or_directory);
  EXPECT_EQ(files_.create(path("")).error(), std::errc::is_a_directory);
  if (!files_.exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  auto full = files_.create("/dev/full");
  if (!full) GTEST_SKIP() << "/dev/full can't be opened: " << full.error().message();
  EXPECT_EQ(full.value()->write_at(0, std::as_bytes(std::span("x"))),
            std::errc::no_space_on_device);
}

TEST_F(FileSystemOfPosix, ErrorsNameThePathAndTheReason) {
  // Goal: each error message names the path that failed and the system's reason.
  const std::string missing = path("missing");
  const std::string below = path("nowhere/file");
  std::filesystem::create_directory(path("folder"));
  const auto expect = [](const std::string& message, const std::string& subject) {
    EXPECT_THAT(message, HasSubstr(subject + ": can't "));
  };
  expect(failure_of([&] { files_.sync_file(missing); }), missing);
  expect(failure_of([&] { files_.sync_directory_of(below); }), path("nowhere"));
  expect(failure_of([&] { files_.rename(missing, path("to")); }), path("to"));
  expect(failure_of([&] { files_.remove(path("folder")); }), path("folder"));
  EXPECT_THAT(failure_of([&] { files_.sync_file(missing); }), HasSubstr("No such file"));
}

TEST_F(FileSystemOfPosix, ReadsTextUpToALimit) {
  // Goal: read_text_file() returns the whole text, or throws an error if the file is too long or
  // can't be read.
  const std::string text("a\0b\n", 4);
  put_bytes(path("text"), text);
  put_bytes(path("empty"), "");
  EXPECT_EQ(read_text_file(path("text"), 4), text);
  EXPECT_EQ(read_text_file(path("text"), 1000), text);
  EXPECT_EQ(read_text_file(path("empty"), 0), "");
  EXPECT_THAT(failure_of([&] { (void)read_text_file(path("text"), 3); }),
              AllOf(HasSubstr(path("text")), HasSubstr("3 bytes")));
  EXPECT_THAT(failure_of([&] { (void)read_text_file(path("none"), 9); }),
              AllOf(HasSubstr(path("none")), HasSubstr("No such file")));
  EXPECT_THAT(failure_of([&] { (void)read_text_file(path(""), 9); }),
              AllOf(HasSubstr(path("")), HasSubstr("Is a directory")));
}

TEST(DirectoryOf, IsTheFolderPart) {
  // Goal: directory_of() returns the folder of a file, for every form of path.
  EXPECT_EQ(directory_of("file"), ".");
  EXPECT_EQ(directory_of("/file"), "/");
  EXPECT_EQ(directory_of("a/file"), "a");
  EXPECT_EQ(directory_of("/a/b/file"), "/a/b");
  EXPECT_EQ(directory_of("a/b/"), "a/b");
}

}  // namespace
}  // namespace sleight::base
