#include "clients/terminal/terminal.h"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <charconv>
#include <vector>

#include "common/base/terminal.h"

namespace sleight::terminal {
namespace {

constexpr std::size_t k_entry_bytes = 16384;

}  // namespace

std::optional<std::size_t> width_of(std::FILE* stream) {
  const auto terminal = base::terminal_at(::fileno(stream));
  return terminal ? std::optional(terminal->columns) : std::nullopt;
}

RenewedLine::RenewedLine(std::FILE* stream) : stream_(stream) {
  const auto terminal = base::terminal_at(::fileno(stream));
  can_renew_ = terminal && terminal->has_escapes;
}

void RenewedLine::show(std::string_view line) {
  // A wrapped line can't be updated, so cut it to the terminal's width, which may have changed.
  const std::size_t width = width_of(stream_).value_or(2) - 1;
  // Carriage return, then clear to the end of the line.
  std::fputs(fmt::format("\r{}\x1b[K", line.substr(0, width)).c_str(), stream_);
  std::fflush(stream_);
  is_open_ = true;
}

void RenewedLine::clear() {
  if (!is_open_) return;
  std::fputs("\r\x1b[K", stream_);
  std::fflush(stream_);
  is_open_ = false;
}

void RenewedLine::finish() {
  if (is_open_) std::fputs("\n", stream_);
  is_open_ = false;
}

bool is_typed() {
  return base::terminal_at(STDIN_FILENO).has_value();
}

bool can_ask() {
  return is_typed() && width_of(stderr).has_value();
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

}  // namespace sleight::terminal
