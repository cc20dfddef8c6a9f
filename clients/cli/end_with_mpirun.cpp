#include "clients/cli/end_with_mpirun.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>

namespace sleight::cli {
namespace {

/// Returns a signal that batch systems and mpirun don't send.
int parent_signal() {
  return SIGRTMIN + 7;
}

/// Open MPI 4 and 5 keep a rank's shared memory in files with these prefixes.
constexpr const char* k_segment_names[] = {"vader_segment.", "sm_segment."};

/// A line of /proc/self/maps may name a file. Removes the file if its name has one of these
/// prefixes.
void unlink_segment(const char* line) {
  const char* path = std::strchr(line, '/');
  if (path == nullptr) return;
  const char* file = std::strrchr(path, '/') + 1;
  for (const char* name : k_segment_names) {
    if (std::strncmp(file, name, std::strlen(name)) == 0) unlink(path);
  }
}

/// Async-signal-safe: uses no streams and allocates no memory. Reads the kernel's list of mappings,
/// because Open MPI doesn't provide the names.
void unlink_mapped_segments() {
  std::array<char, 16384> text;
  const int maps = open("/proc/self/maps", O_RDONLY | O_CLOEXEC);
  if (maps < 0) return;
  std::size_t held = 0;
  while (true) {
    const ssize_t count = read(maps, text.data() + held, text.size() - 1 - held);
    if (count <= 0) break;
    held += static_cast<std::size_t>(count);
    text[held] = '\0';
    char* line = text.data();
    for (char* end = nullptr; (end = std::strchr(line, '\n')) != nullptr; line = end + 1) {
      *end = '\0';
      unlink_segment(line);
    }
    held -= static_cast<std::size_t>(line - text.data());
    std::memmove(text.data(), line, held);
  }
  close(maps);
}

// Each ending thread of mpirun sends the signal, so several threads may handle it at once.
std::atomic_flag is_leaving = ATOMIC_FLAG_INIT;

extern "C" void on_parent_gone(int) {
  if (is_leaving.test_and_set()) return;
  unlink_mapped_segments();
  _exit(128 + SIGKILL);
}

}  // namespace

void end_with_mpirun() {
  struct sigaction action {};
  action.sa_handler = &on_parent_gone;
  sigfillset(&action.sa_mask);
  sigaction(parent_signal(), &action, nullptr);
  prctl(PR_SET_PDEATHSIG, parent_signal());
}

}  // namespace sleight::cli
