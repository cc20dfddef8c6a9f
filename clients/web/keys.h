// The keys that authorize a browser: a secret for its cookie, and single-use tokens to get the
// cookie.
//
// Each key is 256 random bits from the system, as 64 hexadecimal digits. The time of a comparison
// doesn't reveal where keys differ.
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
inline constexpr std::size_t k_tokens_max = 8;  ///< unused tokens; the oldest is dropped

/// Throws base::Error if the system has no random bits.
std::string new_secret();

/// Compares texts in a time that depends only on their lengths.
bool is_same(std::string_view a, std::string_view b);

class Keys {
 public:
  /// Creates a secret if `secret` is empty. Throws base::Error if `secret` doesn't have the form of
  /// new_secret(). `tokens`: unused tokens from before.
  explicit Keys(std::string secret = {}, std::deque<std::string> tokens = {});

  const std::string& secret() const { return secret_; }
  std::string new_token();
  /// Returns true once for each token.
  bool use(std::string_view token);

 private:
  std::string secret_;
  std::mutex mutex_;
  std::deque<std::string> tokens_;
};

}  // namespace sleight::web
