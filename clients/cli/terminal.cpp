#include "clients/cli/terminal.h"

#include <pwd.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <charconv>
#include <vector>

namespace sleight::cli {
namespace {

constexpr std::size_t k_entry_bytes = 16384;

/// The terminal's name for people who pipe through a pager, as other programs have it.
constexpr std::size_t k_width_unknown = 80;

}  // namespace

std::optional<std::size_t> width_of(std::FILE* stream) {
  const int descriptor = ::fileno(stream);
  if (::isatty(descriptor) != 1) return std::nullopt;
  winsize window{};
  const bool known = ::ioctl(descriptor, TIOCGWINSZ, &window) == 0 && window.ws_col > 0;
  return known ? window.ws_col : k_width_unknown;
}

bool can_ask() {
  return ::isatty(STDIN_FILENO) == 1 && ::isatty(STDERR_FILENO) == 1;
}

bool ask(const std::string& question) {
  std::fputs((question + " [y/N] ").c_str(), stderr);
  std::fflush(stderr);
  char answer[16] = {};
  if (std::fgets(answer, sizeof answer, stdin) == nullptr) return false;
  return answer[0] == 'y' || answer[0] == 'Y';
}

std::string name_of_user(std::uint32_t uid) {
  std::vector<char> buffer(k_entry_bytes);
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwuid_r(uid, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr)
    return found->pw_name;
  return std::to_string(uid);
}

std::optional<std::uint32_t> user_of(const std::string& text) {
  std::vector<char> buffer(k_entry_bytes);
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwnam_r(text.c_str(), &entry, buffer.data(), buffer.size(), &found) == 0 &&
      found != nullptr)
    return found->pw_uid;
  std::uint32_t uid = 0;
  const char* end = text.data() + text.size();
  const auto [rest, failure] = std::from_chars(text.data(), end, uid);
  return failure == std::errc() && rest == end ? std::optional(uid) : std::nullopt;
}

}  // namespace sleight::cli
