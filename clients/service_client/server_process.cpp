#include "clients/service_client/server_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

namespace sleight::service_client {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t k_log_read_bytes_max = 64U << 10U;

std::vector<char*> pointers_of(const std::vector<std::string>& command) {
  std::vector<char*> pointers;
  for (const std::string& argument : command)
    pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

/// Creates parent folders with the usual mode, and the last one for its owner only.
void make_state_folder(const std::string& path) {
  std::error_code failure;
  const fs::path parent = fs::path(path).parent_path();
  if (!parent.empty()) fs::create_directories(parent, failure);
  if (failure)
    throw base::Error(fmt::format("can't create {}: {}", parent.string(), failure.message()));
  if (::mkdir(path.c_str(), S_IRWXU) != 0 && errno != EEXIST)
    throw base::Error(fmt::format("can't create {}: {}", path, std::strerror(errno)));
}

/// Runs in the child between fork and exec, so only async-signal-safe calls are allowed.
[[noreturn]] void run_daemon(char* const* command, int log) {
  ::setsid();
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(log, STDOUT_FILENO);
  ::dup2(log, STDERR_FILENO);
  ::close_range(STDERR_FILENO + 1, ~0U, 0);
  ::execv(command[0], command);
  constexpr std::string_view k_words = "can't start sleightd\n";
  static_cast<void>(!::write(STDERR_FILENO, k_words.data(), k_words.size()));
  ::_exit(static_cast<int>(base::ExitCode::environment));
}

}  // namespace

std::string program_beside(const std::string& name) {
  std::error_code failure;
  const fs::path here = fs::read_symlink("/proc/self/exe", failure);
  if (failure) throw base::Error("can't read /proc/self/exe: " + failure.message());
  const std::string path = (here.parent_path() / name).string();
  if (::access(path.c_str(), X_OK) == 0) return path;
  throw base::Error(fmt::format("{}: {}; the program must be in the same folder as {}", path,
                                std::strerror(errno), here.filename().string()));
}

void become(const std::vector<std::string>& command) {
  const std::vector<char*> arguments = pointers_of(command);
  ::execv(arguments.front(), arguments.data());
  throw base::Error(fmt::format("can't start {}: {}", command.front(), std::strerror(errno)));
}

ServerProcess::ServerProcess(const std::vector<std::string>& command,
                             const std::string& state_folder)
    : log_path_((fs::path(state_folder) / "server.log").string()) {
  make_state_folder(state_folder);
  const int log =
      ::open(log_path_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (log < 0)
    throw base::Error(fmt::format("can't write {}: {}", log_path_, std::strerror(errno)));
  struct stat file {};
  if (::fstat(log, &file) == 0) log_began_ = static_cast<std::uint64_t>(file.st_size);
  const std::vector<char*> arguments = pointers_of(command);
  pid_ = ::fork();
  if (pid_ == 0) run_daemon(arguments.data(), log);
  const int failure = errno;
  ::close(log);
  if (pid_ < 0) throw base::Error(fmt::format("can't start a process: {}", std::strerror(failure)));
}

bool ServerProcess::is_running() {
  if (!has_ended_) has_ended_ = ::waitpid(pid_, &status_, WNOHANG) == pid_;
  return !has_ended_;
}

base::ExitCode ServerProcess::exit_code() const {
  const int code = has_ended_ && WIFEXITED(status_) ? WEXITSTATUS(status_) : 0;
  const bool is_ours = (code > 0 && code <= static_cast<int>(base::ExitCode::environment)) ||
                       code == static_cast<int>(base::ExitCode::not_allowed);
  return is_ours ? static_cast<base::ExitCode>(code) : base::ExitCode::environment;
}

std::vector<std::string> ServerProcess::log_lines(std::size_t count_max) const {
  std::ifstream log(log_path_, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(log.tellg(), 0));
  const std::uint64_t from = std::max(log_began_, size - std::min(size, k_log_read_bytes_max));
  log.seekg(static_cast<std::streamoff>(from));
  std::vector<std::string> lines;
  for (std::string line; std::getline(log, line);)
    lines.push_back(line);
  if (lines.size() > count_max)
    lines.erase(lines.begin(), lines.end() - static_cast<std::ptrdiff_t>(count_max));
  return lines;
}

}  // namespace sleight::service_client
