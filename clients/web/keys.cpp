#include "clients/web/keys.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>

#include "common/base/error.h"

namespace sleight::web {

std::string new_secret() {
  std::array<std::uint8_t, k_secret_digits / 2> bits{};
  std::size_t filled = 0;
  while (filled < bits.size()) {
    const ssize_t count = ::getrandom(bits.data() + filled, bits.size() - filled, 0);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      throw base::Error(fmt::format("cannot get random numbers from the system: {}",
                                    std::generic_category().message(errno)));
    }
    filled += static_cast<std::size_t>(count);
  }
  std::string digits;
  for (const std::uint8_t byte : bits)
    fmt::format_to(std::back_inserter(digits), "{:02x}", byte);
  return digits;
}

bool is_same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  // The variable is volatile, so that the compiler doesn't end this loop early.
  volatile unsigned char differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    differs = static_cast<unsigned char>(differs | (a[i] ^ b[i]));
  return differs == 0;
}

Keys::Keys(std::string secret, std::deque<std::string> tokens)
    : secret_(secret.empty() ? new_secret() : std::move(secret)), tokens_(std::move(tokens)) {
  const bool is_hex = std::ranges::all_of(
      secret_, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
  if (secret_.size() != k_secret_digits || !is_hex) {
    throw base::Error(
        fmt::format("a page's secret must be {} lower-case hexadecimal digits", k_secret_digits));
  }
}

std::string Keys::new_token() {
  std::string token = new_secret();
  const std::lock_guard lock(mutex_);
  while (tokens_.size() >= k_tokens_max)
    tokens_.pop_front();
  tokens_.push_back(token);
  return token;
}

bool Keys::use(std::string_view token) {
  const std::lock_guard lock(mutex_);
  // Compares all tokens, so that the time doesn't reveal which one matched.
  auto found = tokens_.end();
  for (auto held = tokens_.begin(); held != tokens_.end(); ++held)
    if (is_same(*held, token)) found = held;
  if (found == tokens_.end()) return false;
  tokens_.erase(found);
  return true;
}

}  // namespace sleight::web
