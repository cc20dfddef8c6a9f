#include "common/archive/reader_program/program.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string_view>
#include <system_error>

#include "common/archive/hdf5/reader.h"
#include "common/archive/reader_program/answers.h"
#include "common/archive/reader_program/confine.h"
#include "common/archive/remote/messages.h"
#include "common/base/error.h"

namespace sleight::archive::reader_program {
namespace {

constexpr int k_bug = static_cast<int>(base::ExitCode::bug);

/// Parses the only argument. Returns 0 if the argument is invalid.
std::uint64_t memory_bytes_of(int argc, const char* const* argv) {
  std::uint64_t bytes = 0;
  if (argc != 2) return 0;
  const std::string_view word = argv[1];
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), bytes);
  return error == std::errc() && end == word.data() + word.size() ? bytes : 0;
}

bool has_its_descriptors(Given& given) {
  struct stat archive {};
  if (::fstat(remote::k_archive_descriptor, &archive) != 0 || !S_ISREG(archive.st_mode))
    return false;
  given.archive_bytes = static_cast<std::uint64_t>(archive.st_size);
  return ::fcntl(remote::k_questions_descriptor, F_GETFD) >= 0 &&
         ::fcntl(remote::k_answers_descriptor, F_GETFD) >= 0 &&
         ::fcntl(remote::k_lifeline_descriptor, F_GETFD) >= 0;
}

int refuse_to_start(const char* reason) {
  std::fprintf(stderr, "sleight-reader: %s\n", reason);
  return static_cast<int>(base::ExitCode::usage);
}

}  // namespace

int run_confined(int argc, const char* const* argv, const std::function<int(const Given&)>& work) {
  Given given{.memory_bytes = memory_bytes_of(argc, argv)};
  if (given.memory_bytes == 0 || !has_its_descriptors(given))
    return refuse_to_start("this program is started only by sleight, to read archives");
  // Ignore SIGPIPE, so that a write to a closed pipe fails like any other write.
  std::signal(SIGPIPE, SIG_IGN);
  int code = k_bug;
  try {
    hdf5::start();
    end_with_lifeline(remote::k_lifeline_descriptor);
    confine(given.memory_bytes);
    code = work(given);
  } catch (const std::exception& error) {
    // `work` sends errors about the archive to the client and doesn't throw them. So an exception
    // here means that the process could not be confined.
    const std::string_view reason = error.what();
    say({.kind = remote::AnswerKind::refusal,
         .type = remote::k_of_environment,
         .bytes = reason.size()},
        std::as_bytes(std::span<const char>(reason)));
  }
  // Skip the libraries' exit handlers, whose system calls are not permitted.
  ::_exit(code);
}

int read_and_answer(const Given& given) {
  const auto open = [&given] {
    return hdf5::open_descriptor(
        k_nameless, {.descriptor = remote::k_archive_descriptor, .bytes = given.archive_bytes});
  };
  return answer(open, given.memory_bytes);
}

}  // namespace sleight::archive::reader_program
