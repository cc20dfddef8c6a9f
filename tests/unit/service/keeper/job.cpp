#include "tests/unit/service/keeper/job.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>
#include <utility>

namespace sleight::keeper::testing {
namespace {

std::string content_of(const std::string& path) {
  // If the process ends meanwhile, `<<` counts the read error as the end of the file.
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return std::move(text).str();
}

}  // namespace

bool comes_true(const std::function<bool()>& question) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!question()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

std::vector<pid_t> processes_with(const std::string& words) {
  std::vector<pid_t> found;
  std::error_code error;
  for (std::filesystem::directory_iterator i("/proc", error), end; !error && i != end;
       i.increment(error)) {
    const std::string name = i->path().filename().string();
    pid_t pid = 0;
    const auto [stop, bad] = std::from_chars(name.data(), name.data() + name.size(), pid);
    if (bad != std::errc() || pid == ::getpid()) continue;
    // Empty for a zombie.
    if (content_of(i->path() / "cmdline").find(words) != std::string::npos) found.push_back(pid);
  }
  return found;
}

JobTest::JobTest() {
  std::string name = std::filesystem::temp_directory_path() / "sleight-test-XXXXXX";
  folder_ = ::mkdtemp(name.data());
}

JobTest::~JobTest() {
  // The command lines of all keepers and scripts contain the folder's name.
  for (const pid_t left : processes_with(folder_))
    ::kill(left, SIGKILL);
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
}

void JobTest::program_is(const std::string& script) {
  std::ofstream(path("program")) << "#!/bin/sh\n" << script << "\n";
  std::filesystem::permissions(path("program"), std::filesystem::perms::owner_all);
}

LocalBackend JobTest::backend(bool dies) const {
  const auto tests = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  return LocalBackend(
      {.keeper = dies ? tests / "sleight-dying-keeper" : tests.parent_path() / "bin/sleight-keeper",
       .sleight = path("program"),
       .sleight_batch = "/bin/true",
       .mpirun = path("program")});
}

AttemptSpec JobTest::spec(std::uint32_t attempt) const {
  return {.folder = folder_, .attempt = attempt};
}

Look JobTest::await_end(std::uint32_t attempt) const {
  const LocalBackend local = backend();
  Look look;
  const bool ends = comes_true([&] {
    look = local.look(folder_, attempt);
    if (look.state != Look::State::running) return true;
    if (const auto keeper = local.adopt(folder_, attempt)) {
      pollfd wait{.fd = keeper->descriptor(), .events = POLLIN, .revents = 0};
      ::poll(&wait, 1, 20'000);
    }
    return false;
  });
  EXPECT_TRUE(ends) << "it runs on";
  return look;
}

AttemptEnd JobTest::run(const AttemptSpec& spec) const {
  const RunningKeeper keeper = backend().launch(spec);
  EXPECT_TRUE(comes_true([&] { return keeper.has_gone(); }));
  const Look look = backend().look(folder_, spec.attempt);
  EXPECT_EQ(look.state, Look::State::ended) << look.words;
  return look.record && look.record->end ? *look.record->end : AttemptEnd{};
}

std::string JobTest::text_in(const std::string& name) const {
  return content_of(path(name));
}

std::vector<std::string> JobTest::lines_in(const std::string& name) const {
  std::ifstream file(path(name));
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);)
    lines.push_back(line);
  return lines;
}

void JobTest::await_file(const std::string& name) const {
  EXPECT_TRUE(comes_true([&] { return text_in(name).ends_with('\n'); })) << name;
}

}  // namespace sleight::keeper::testing
