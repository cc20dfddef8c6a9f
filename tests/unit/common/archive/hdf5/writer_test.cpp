// Goal: a file holds the values of the in-memory archive. Equal content gives equal bytes. If a
// write fails, the old file stays. Method: compare digests. Compare files that different processes
// wrote. Limit the size of files. Let calls of the file system fail.
#include "common/archive/hdf5/writer.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>

#include "common/archive/digest/digest.h"
#include "common/archive/digest/verify.h"
#include "common/archive/hdf5/output_file.h"
#include "common/archive/hdf5/reader.h"
#include "common/base/error.h"
#include "tests/archive/memory_archive.h"
#include "tests/support/property.h"
#include "tests/unit/common/archive/fake_world.h"
#include "tests/unit/common/archive/hdf5/scratch.h"
#include "tests/unit/common/base/faulty_file_system.h"

namespace sleight::archive::hdf5 {
namespace {

using archive::testing::FakeRunOptions;
using archive::testing::filler;
using archive::testing::NamedReader;
using base::testing::FaultyFileSystem;
using base::testing::FileCall;
using base::testing::name_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Writer : public archive::testing::Scratch {
 protected:
  base::PosixFileSystem files_;
};

TEST_F(Writer, FilesAndMemoryHaveOneDigest) {
  // The last two runs are longer than a batch, so their datasets have several chunks and a shorter
  // last chunk.
  const std::vector<FakeRunOptions> runs{{},
                                         {.chains = 1, .scans = 1, .satisfied_share = 0},
                                         {.chains = 1, .scans = 1, .satisfied_share = 1},
                                         {.chains = 5, .scans = 2, .thin = 100},
                                         {.chains = 2, .scans = 40000, .thin = 1},
                                         {.chains = 3, .scans = 16384, .thin = 2}};
  for (const FakeRunOptions& run : runs) {
    MemoryArchive memory;
    const std::string expected = write_digested(memory, filler(run));
    EXPECT_EQ(write_file(path("a.h5"), files_, filler(run)), expected);
    const auto source = open_file(path("a.h5"));
    EXPECT_EQ(manifest(*source), manifest(memory));
    EXPECT_EQ(digest(*source), expected);
    EXPECT_THAT(verify(*source), ::testing::IsEmpty());
  }
  EXPECT_THAT(names(), ElementsAre("a.h5"));
}

TEST_F(Writer, NamesOfIndicesAreCoordinates) {
  // Goal: if a world's dimension has names, its coordinate is these names in every group, and the
  // archive passes all checks. Other coordinates stay numbers.
  const FakeRunOptions run{.finds = 2};
  MemoryArchive memory;
  const std::string expected = write_digested(memory, filler<NamedReader>(run));
  EXPECT_EQ(write_file(path("a.h5"), files_, filler<NamedReader>(run)), expected);
  const auto source = open_file(path("a.h5"));
  EXPECT_EQ(manifest(*source), manifest(memory));
  EXPECT_THAT(verify(*source), ::testing::IsEmpty());
  for (const char* group : {"/posterior", "/replicas", "/prior", "/animations", "/finds"}) {
    EXPECT_EQ(source->read(group, "collision", 0, 3), Values(NamedReader::names())) << group;
    EXPECT_EQ(source->read(group, "axis", 0, 2), Values(std::vector<std::int64_t>{0, 1})) << group;
  }
}

TEST_F(Writer, ReadsAnyRangeOfElements) {
  const FakeRunOptions run{.chains = 3, .scans = 700, .thin = 1};
  MemoryArchive memory;
  write_digested(memory, filler(run));
  write_file(path("a.h5"), files_, filler(run));
  const auto source = open_file(path("a.h5"));
  const std::uint64_t total = 3 * 700 * 6;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const std::uint64_t first = archive::testing::mixed(seed) % total;
    const std::uint64_t count = archive::testing::mixed(seed + 1000) % (total - first + 1);
    ASSERT_EQ(source->read("/posterior", "spin_radps", first, count),
              memory.read("/posterior", "spin_radps", first, count))
        << first << " " << count;
  }
}

TEST_F(Writer, EqualContentIsEqualBytesInEveryProcess) {
  // MALLOC_PERTURB_ fills new and freed memory with a given byte. If the writer wrote uninitialised
  // memory, the files would differ.
  std::string first;
  for (const char* byte : {"0", "165", "90", "255"}) {
    const std::string file = path("sample.h5");
    const std::string command = fmt::format("MALLOC_PERTURB_={} '{}' '{}' 20000 > /dev/null", byte,
                                            SLEIGHT_SAMPLE_ARCHIVE, file);
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    const std::string bytes = bytes_of(file);
    ASSERT_GT(bytes.size(), 100'000U);
    if (first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first) << "MALLOC_PERTURB_=" << byte;
  }
  // If a process writes the same archive twice, both files have the same bytes.
  const FakeRunOptions run{.scans = 20000};
  write_file(path("x.h5"), files_, filler({.chains = 1}));
  write_file(path("y.h5"), files_, filler(run));
  const std::string once = bytes_of(path("y.h5"));
  write_file(path("y.h5"), files_, filler(run));
  EXPECT_TRUE(bytes_of(path("y.h5")) == once);
}

TEST_F(Writer, FoldersThatCannotBeWrittenAreNamed) {
  for (const std::string& place : {path("missing/a.h5"), std::string("/proc/self/a.h5")}) {
    try {
      write_file(place, files_, filler({}));
      FAIL() << place;
    } catch (const base::Error& error) {
      EXPECT_EQ(error.exit_code(), base::ExitCode::environment);
      EXPECT_THAT(error.what(), HasSubstr(place));
    }
  }
}

TEST_F(Writer, AFullDiskLeavesTheOldFileAlone) {
  const FakeRunOptions run{.scans = 5000, .prior_draws = 1000};
  write_file(path("a.h5"), files_, filler({.chains = 1}));
  const std::string old = bytes_of(path("a.h5"));
  write_file(path("b.h5"), files_, filler(run));
  const std::string whole = bytes_of(path("b.h5"));

  // One process tries all limits. A failed write must not harm the next write.
  const auto write_within_limits = [&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const auto try_with = [&](rlim_t bytes) {
      struct rlimit limit {};
      ::getrlimit(RLIMIT_FSIZE, &limit);
      limit.rlim_cur = bytes;
      ::setrlimit(RLIMIT_FSIZE, &limit);
      write_file(path("a.h5"), files_, filler(run));
    };
    const rlim_t step = whole.size() / property::of_tier(10, 60) + 1;
    for (rlim_t bytes = 0; bytes < whole.size(); bytes += step) {
      try {
        try_with(bytes);
        throw std::runtime_error(fmt::format("written within {} bytes", bytes));
      } catch (const base::Error& error) {
        if (std::string(error.what()).find("File too large") == std::string::npos) throw;
      }
      if (bytes_of(path("a.h5")) != old) throw std::runtime_error("the old file has changed");
      if (names().size() != 2) throw std::runtime_error("something was left behind");
    }
    try_with(whole.size());
    std::_Exit(0);
  };
  EXPECT_EXIT(write_within_limits(), ::testing::ExitedWithCode(0), "");
  EXPECT_TRUE(bytes_of(path("a.h5")) == whole);
}

TEST_F(Writer, FailuresOfTheFileSystemLeaveAWholeFile) {
  write_file(path("a.h5"), files_, filler({.chains = 1}));
  const std::string old = bytes_of(path("a.h5"));
  for (const FileCall call : {FileCall::create, FileCall::write, FileCall::close,
                              FileCall::sync_file, FileCall::rename, FileCall::sync_directory}) {
    FaultyFileSystem failing;
    failing.fail({.call = call, .reason = std::errc::io_error});
    try {
      write_file(path("a.h5"), failing, filler({}));
      ADD_FAILURE() << name_of(call);
    } catch (const base::Error& error) {
      EXPECT_EQ(error.exit_code(), base::ExitCode::environment);
      EXPECT_THAT(error.what(), AllOf(HasSubstr(path("")), HasSubstr("Input/output error")));
    }
    EXPECT_GE(failing.failures(), 1U) << name_of(call);
    EXPECT_THAT(names(), ElementsAre("a.h5")) << name_of(call);
    // Only sync_directory is called after the new file is renamed to its final name.
    EXPECT_EQ(bytes_of(path("a.h5")) == old, call != FileCall::sync_directory);
    EXPECT_THAT(verify(*open_file(path("a.h5"))), ::testing::IsEmpty());
  }
}

TEST_F(Writer, AFileHasItsAllocatedLength) {
  // Goal: even if HDF5 never writes a file's last bytes, the file has its full length. If the file
  // can't be extended, the failure is reported. Method: create a dataset whose space is allocated
  // but never written.
  const hsize_t bytes = 100000;
  const auto write = [&](base::FileSystem& files) {
    OutputFile output(path("a.h5"), files);
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    EXPECT_GE(output.use_in(access), 0);
    const hid_t file = H5Fcreate("unused", H5F_ACC_TRUNC, H5P_DEFAULT, access);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
    H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
    const hid_t space = H5Screate_simple(1, &bytes, nullptr);
    const hid_t values =
        H5Dcreate2(file, "x", H5T_NATIVE_INT8, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    EXPECT_GE(H5Dclose(values), 0);
    H5Sclose(space);
    H5Pclose(creation);
    EXPECT_GE(H5Fclose(file), 0);
    H5Pclose(access);
    output.close();
  };
  write(files_);
  EXPECT_GE(bytes_of(path("a.h5")).size(), bytes);
  FaultyFileSystem failing;
  failing.fail({.call = FileCall::resize, .reason = std::errc::io_error});
  EXPECT_THROW(write(failing), base::Error);
  EXPECT_EQ(failing.failures(), 1U);
}

TEST_F(Writer, EachCallMayFailOnce) {
  // Goal: whichever call of the file system fails, the old file stays or the complete new file
  // replaces it. Method: for k = 1, 2, ..., let only the k-th call fail, until a write succeeds.
  // Sanitizer builds try every third k.
#ifdef SLEIGHT_SANITIZED
  constexpr std::uint64_t k_step = 3;
#else
  constexpr std::uint64_t k_step = 1;
#endif
  const FakeRunOptions run{.scans = 60};
  write_file(path("b.h5"), files_, filler(run));
  const std::string whole = bytes_of(path("b.h5"));
  write_file(path("a.h5"), files_, filler({.chains = 1}));
  const std::string old = bytes_of(path("a.h5"));
  std::uint64_t call = 0;
  for (bool got_through = false; !got_through; call += k_step) {
    SCOPED_TRACE(call);
    std::ofstream(path("a.h5"), std::ios::binary) << old;
    FaultyFileSystem failing;
    failing.fail({.after = call, .times = 1, .reason = std::errc::no_space_on_device});
    bool thrown = false;
    try {
      write_file(path("a.h5"), failing, filler(run));
    } catch (const base::Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("No space left on device"));
      thrown = true;
    }
    got_through = failing.failures() == 0;
    EXPECT_NE(thrown, got_through);
    const std::string found = bytes_of(path("a.h5"));
    EXPECT_TRUE(found == whole || (found == old && thrown));
    EXPECT_THAT(names(), ::testing::UnorderedElementsAre("a.h5", "b.h5"));
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(call, 10U);
}

TEST_F(Writer, WhatFillThrowsComesThrough) {
  const auto fill = [](Sink& sink) {
    sink.create_group("/posterior");
    throw base::Error(base::ExitCode::conflict, "from fill");
  };
  try {
    write_file(path("a.h5"), files_, fill);
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::conflict);
  }
  EXPECT_TRUE(names().empty());
}

}  // namespace
}  // namespace sleight::archive::hdf5
