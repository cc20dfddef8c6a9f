// Goal: the calling program survives any archive and any fault of a reader process, and reports the
// cause. Method: open sound and damaged archives with the real reader. Also use a faulty reader
// (lying_reader.cpp), which crashes, hangs, sends wrong answers or makes forbidden calls.
#include "common/archive/remote/remote_source.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "common/archive/digest/digest.h"
#include "common/archive/digest/verify.h"
#include "common/archive/format.h"
#include "common/archive/hdf5/writer.h"
#include "common/archive/remote/messages.h"
#include "common/base/error.h"
#include "tests/support/facts.h"
#include "tests/unit/common/archive/fake_world.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::archive::remote {
namespace {

using ::testing::HasSubstr;

constexpr const char* k_reader = SLEIGHT_READER;
constexpr const char* k_liar = SLEIGHT_LYING_READER;

/// Returns the message of the error that `work` throws. Fails if `work` throws nothing, or if the
/// error's exit code isn't `code`.
std::string reason_of(const std::function<void()>& work,
                      base::ExitCode code = base::ExitCode::bad_archive) {
  try {
    work();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const base::Error& error) {
    EXPECT_EQ(static_cast<int>(error.exit_code()), static_cast<int>(code)) << error.what();
    return error.what();
  }
  return {};
}

class Remote : public archive::testing::Scratch {
 protected:
  ~Remote() override {
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a reader was left behind";
  }

  std::string write(const std::string& name, std::uint32_t chains) {
    base::PosixFileSystem files;
    digest_ = hdf5::write_file(
        path(name), files, archive::testing::filler({.chains = chains, .scans = 300, .thin = 10}));
    return path(name);
  }

  /// Writes a file that contains only `word`, and returns the file's path. The word tells the lying
  /// reader what to do.
  std::string telling(const std::string& word) {
    put_bytes(path(word), word);
    return path(word);
  }

  std::string why_refused(const std::string& word, const ReaderLimits& limits = {}) {
    const std::string file = telling(word);
    const std::string reason = reason_of([&] { open_remote_by(k_liar, file, limits); });
    EXPECT_THAT(reason, ::testing::StartsWith(file + ": "));
    return reason;
  }

  /// Returns the message of the error that a wrong answer causes. A second question must fail with
  /// the same message.
  std::string why_not_read(const std::string& word, const std::string& dataset = "draw",
                           const ReaderLimits& limits = {}) {
    const auto source = open_remote_by(k_liar, telling(word), limits);
    const auto ask = [&] { source->read(k_posterior, dataset, 0, 4); };
    const std::string reason = reason_of(ask);
    EXPECT_EQ(reason_of(ask), reason);
    return reason;
  }

  std::string digest_;
};

TEST_F(Remote, ReadsAllThatTheFileHolds) {
  const auto source = open_remote_by(k_reader, write("a.h5", 2));
  EXPECT_EQ(digest(*source), digest_);
  EXPECT_TRUE(verify(*source).empty());
  EXPECT_EQ(count_of(view_of(source->read(k_posterior, "draw", 0, 0))), 0U);
  EXPECT_EQ(std::get<std::vector<std::int64_t>>(source->read(k_posterior, "draw", 2, 2)),
            (std::vector<std::int64_t>{20, 30}));
  EXPECT_EQ(std::get<std::vector<std::int64_t>>(source->read(k_posterior, "draw", 0, 1)),
            (std::vector<std::int64_t>{0}));
}

TEST_F(Remote, SaysWhatIsNoArchive) {
  put_bytes(path("text.h5"), std::string(3000, 'x'));
  EXPECT_EQ(reason_of([&] { open_remote_by(k_reader, path("text.h5")); }),
            path("text.h5") + ": not an HDF5 file");
  std::filesystem::create_directory(path("folder.h5"));
  EXPECT_EQ(reason_of([&] { open_remote_by(k_reader, path("folder.h5")); }),
            path("folder.h5") + ": not a regular file");
  EXPECT_THAT(
      reason_of([&] { open_remote_by(k_reader, path("none.h5")); }, base::ExitCode::environment),
      HasSubstr("can't open"));
  EXPECT_THAT(reason_of([&] { open_remote_by(path("no-reader"), write("a.h5", 1)); },
                        base::ExitCode::environment),
              HasSubstr("install it in the folder"));
}

TEST_F(Remote, SeveralArchivesFromSeveralThreads) {
  constexpr std::uint32_t k_threads = 4;
  std::array<std::string, k_threads> files;
  std::array<std::string, k_threads> digests;
  for (std::uint32_t i = 0; i < k_threads; ++i) {
    files[i] = write("a" + std::to_string(i) + ".h5", i + 1);
    digests[i] = digest_;
  }
  std::array<int, k_threads> equal{};
  std::vector<std::thread> threads;
  for (std::uint32_t i = 0; i < k_threads; ++i) {
    threads.emplace_back([&, i] {
      const auto mine = open_remote_by(k_reader, files[i]);
      const auto next = open_remote_by(k_reader, files[(i + 1) % k_threads]);
      equal[i] = static_cast<int>(digest(*mine) == digests[i]) +
                 static_cast<int>(digest(*next) == digests[(i + 1) % k_threads]);
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_THAT(equal, ::testing::Each(2));
}

TEST_F(Remote, OfAListEachHasItsPlace) {
  std::string damaged = bytes_of(write("a.h5", 1));
  put_bytes(path("cut.h5"), damaged.substr(0, damaged.size() / 2));
  const std::vector<std::string> paths{path("none.h5"), path("a.h5"), path("cut.h5"), path("a.h5")};
  const std::vector<OpenedArchive> opened = open_all_by(k_reader, paths);
  ASSERT_EQ(opened.size(), paths.size());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    EXPECT_EQ(opened[i].path, paths[i]);
    EXPECT_EQ(opened[i].source != nullptr, i % 2 == 1);
    EXPECT_EQ(opened[i].refused.empty(), i % 2 == 1) << opened[i].refused;
    if (opened[i].source) {
      EXPECT_EQ(digest(*opened[i].source), digest_);
    }
  }
  EXPECT_THAT(opened[0].refused, HasSubstr("none.h5: can't open"));
  EXPECT_THAT(opened[2].refused, HasSubstr("cut.h5: "));
}

TEST_F(Remote, ThoseThatHangCostAListOneTimeLimit) {
  std::vector<std::string> paths;
  for (int i = 0; i < 8; ++i) {
    paths.push_back(path("a" + std::to_string(i)));
    put_bytes(paths.back(), i == 5 ? "honest" : "silent");
  }
  const auto start = std::chrono::steady_clock::now();
  const std::vector<OpenedArchive> opened = open_all_by(k_liar, paths, {.timeout_s = 2});
  // If the program waited for one reader after another, it would take 14 s.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  for (std::size_t i = 0; i < paths.size(); ++i)
    EXPECT_EQ(opened[i].source != nullptr, i == 5) << opened[i].refused;
}

TEST_F(Remote, AReaderThatEndsOrHangsIsNamed) {
  EXPECT_THAT(why_refused("exit"), HasSubstr("exited early with code 3"));
  EXPECT_THAT(why_refused("silent", {.timeout_s = 0.2}), HasSubstr("more than 0.2 s"));
  EXPECT_THAT(why_refused("spin", {.cpu_s = 1, .timeout_s = 60}),
              HasSubstr("more than 1 s of processor time"));
  EXPECT_THAT(why_not_read("late", "draw", {.timeout_s = 2}), HasSubstr("more than 2 s"));
#ifndef SLEIGHT_SANITIZED
  // Sanitizers handle crashes themselves.
  EXPECT_THAT(why_refused("crash"), HasSubstr("crashed (Illegal instruction)"));
  EXPECT_THAT(why_not_read("crash_later"), HasSubstr("crashed (Illegal instruction)"));
  EXPECT_THAT(why_refused("bomb", {.address_space_bytes = std::uint64_t{256} << 20}),
              tests::HasFacts("268435456 bytes of memory"));
#endif
}

TEST_F(Remote, AKilledReaderIsNamed) {
  telling("honest");
  const base::Descriptor archive(::open(path("honest").c_str(), O_RDONLY | O_CLOEXEC));
  ReaderProcess process(k_liar, archive.get(), {});
  ASSERT_EQ(::kill(process.id(), SIGKILL), 0);
  std::array<std::byte, 1> byte{};
  while (process.receive(byte) == Received::all) {
  }
  // The kernel closes the pipes of a dead process one by one, so try to send until a send fails.
  bool is_heard = true;
  for (int i = 0; i < 1000 && is_heard; ++i) {
    is_heard = process.send(byte);
    ::usleep(1000);
  }
  EXPECT_FALSE(is_heard);
  EXPECT_THAT(process.end().words, HasSubstr("was killed, by a user"));
}

TEST_F(Remote, LiesAboutContentsAreFound) {
  EXPECT_THAT(why_refused("huge_contents"), tests::HasFacts("first message|contents"));
  EXPECT_THAT(why_refused("broken_contents"), HasSubstr("list of contents is malformed"));
  EXPECT_THAT(why_refused("escaping_name"), HasSubstr("invalid name"));
}

TEST_F(Remote, LiesAboutValuesAreFound) {
  for (const char* word : {"fewer", "huge"})
    EXPECT_THAT(why_not_read(word), HasSubstr("wrong number of values"));
  for (const char* word : {"type", "kind"})
    EXPECT_THAT(why_not_read(word), HasSubstr("other than the requested values"));
  for (const char* word : {"number", "padding"})
    EXPECT_THAT(why_not_read(word), HasSubstr("a different request"));
  EXPECT_THAT(why_not_read("blame"), HasSubstr("malformed error message"));
  EXPECT_THAT(why_not_read("half"), HasSubstr("exited early with code 0"));
  EXPECT_THAT(why_not_read("escape", "words"),
              HasSubstr("/posterior/words: the text contains control"));
  EXPECT_THAT(why_not_read("long_text", "words"), HasSubstr("the texts are malformed"));
}

TEST_F(Remote, WordsThatNobodyAskedForAreFound) {
  // The reader sends the right first answer and then one more byte. A later question must fail.
  const auto source = open_remote_by(k_liar, telling("more"));
  source->read(k_posterior, "draw", 0, 4);
  std::string reason;
  for (int i = 0; i < 1000 && reason.empty(); ++i) {
    try {
      source->read(k_posterior, "draw", 0, 4);
    } catch (const base::Error& error) {
      reason = error.what();
    }
  }
  EXPECT_THAT(reason,
              ::testing::AnyOf(HasSubstr("without a request"), HasSubstr("a different request")));
  EXPECT_THAT(why_not_read("unasked"),
              ::testing::AnyOf(HasSubstr("without a request"), HasSubstr("something other")));
}

TEST_F(Remote, ARefusalIsNoEnd) {
  const auto source = open_remote_by(k_liar, telling("refusal"));
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(reason_of([&] { source->read(k_posterior, "draw", 0, 4); }),
              path("refusal") + ": a chunk is damaged ?[2J");
  }
}

TEST_F(Remote, WhatReadingDoesntNeedIsForbidden) {
  for (const char* word : {"socket", "write", "fork", "kill", "exec"})
    EXPECT_THAT(why_refused(word), HasSubstr("forbidden system call")) << word;
  EXPECT_FALSE(std::filesystem::exists("/tmp/sleight-lying-reader"));
  EXPECT_EQ(
      count_of(view_of(open_remote_by(k_liar, telling("honest"))->read(k_posterior, "draw", 0, 4))),
      4U);
}

TEST_F(Remote, AReaderHasNothingButItsOwn) {
  telling("honest");
  // A reader inherits neither this program's open files nor other readers' pipes.
  const base::Descriptor archive(::open(path("honest").c_str(), O_RDONLY | O_CLOEXEC));
  const base::Descriptor inherited(::open("/dev/null", O_RDONLY));
  const auto other = open_remote_by(k_liar, path("honest"));
  ReaderProcess process(k_liar, archive.get(), {});
  std::array<std::byte, k_head_bytes> head{};
  ASSERT_EQ(process.receive(head), Received::all);
  const std::string place = "/proc/" + std::to_string(process.id());
  std::vector<std::string> descriptors;
  for (const auto& entry : std::filesystem::directory_iterator(place + "/fd"))
    descriptors.push_back(entry.path().filename());
  EXPECT_THAT(descriptors, ::testing::UnorderedElementsAre("0", "1", "2", "3", "4"));
  EXPECT_THAT(bytes_of(place + "/environ"), ::testing::Not(HasSubstr("PATH=")));
}

TEST_F(Remote, EndsWithTheProgramThatAsks) {
  telling("spin");
  // This process is a subreaper. If the reader's parent dies, this process adopts the reader and
  // can wait for its end.
  ASSERT_EQ(::prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0), 0);
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const int archive = ::open(path("spin").c_str(), O_RDONLY | O_CLOEXEC);
    ReaderProcess process(k_liar, archive, {});
    const pid_t reader = process.id();
    // Wait until the reader has used 0.3 s of processor time. Its start takes less.
    clockid_t clock{};
    timespec used{};
    while (::clock_getcpuclockid(reader, &clock) == 0 && ::clock_gettime(clock, &used) == 0 &&
           used.tv_sec == 0 && used.tv_nsec < 300'000'000)
      ::usleep(5'000);
    if (::write(ends[1], &reader, sizeof reader) != sizeof reader) ::_exit(1);
    while (true)
      ::pause();
  }
  pid_t reader = -1;
  ASSERT_EQ(::read(ends[0], &reader, sizeof reader), static_cast<ssize_t>(sizeof reader));
  EXPECT_EQ(::kill(reader, 0), 0) << "it has ended before";
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  int status = 0;
  pid_t got = 0;
  for (int i = 0; i < 1000 && got == 0; ++i) {
    got = ::waitpid(reader, &status, WNOHANG);
    if (got == 0) ::usleep(10'000);
  }
  if (got == 0) ::kill(reader, SIGKILL);
  EXPECT_EQ(got, reader);
  ::prctl(PR_SET_CHILD_SUBREAPER, 0, 0, 0, 0);
  ::close(ends[0]);
  ::close(ends[1]);
}

}  // namespace
}  // namespace sleight::archive::remote
