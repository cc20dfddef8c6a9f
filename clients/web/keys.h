// What lets a browser in: a secret for its cookie, and tokens that are each used once to get it.
//
// All are 256 bits of the system's, as 64 hexadecimal digits. They are compared in a time that says
// nothing of where they differ.
//
// Thread safety: all functions may be called from any thread.
#pragma once

#include <cstddef>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>

namespace sleight::web {

inline constexpr std::size_t k_secret_digits = 64;
inline constexpr std::size_t k_tokens_max = 8;  ///< that are unused; the oldest goes

/// Throws base::Error where the system has no random bits.
std::string new_secret();

/// In a time that hangs on the lengths alone.
bool is_same(std::string_view a, std::string_view b);

class Keys {
 public:
  /// An empty secret: a new one. Throws base::Error where it is none of new_secret's. `tokens` are
  /// unused ones of before.
  explicit Keys(std::string secret = {}, std::deque<std::string> tokens = {});

  const std::string& secret() const { return secret_; }
  std::string new_token();
  /// True once for each token.
  bool use(std::string_view token);

 private:
  std::string secret_;
  std::mutex mutex_;
  std::deque<std::string> tokens_;
};

}  // namespace sleight::web
