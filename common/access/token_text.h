// Tokens as text, which people copy: what a client over TCP shows to be let in.
//
//   sleight_7k2m9q4x1c_<52 characters: 256 random bits><7 characters: check>
//
// The prefix lets tools that look for lost secrets find one. The id names the token in lists and
// logs and is no secret. The check finds what was mistyped or cut off before it is sent. Characters
// are Crockford's base 32, small ones.
//
// A service keeps the hash alone. The secret is random throughout, so a plain SHA-256 hides it.
//
// Thread safety: pure functions, but for `draw_token`, which asks the system for random bits.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::access {

inline constexpr std::string_view k_token_prefix = "sleight_";
inline constexpr std::size_t k_token_id_characters = 10;
inline constexpr std::size_t k_token_secret_bytes = 32;
/// Of a whole token.
inline constexpr std::size_t k_token_characters =
    k_token_prefix.size() + k_token_id_characters + 1 + 52 + 7;

struct Token {
  std::string id{};
  std::array<std::byte, k_token_secret_bytes> secret{};
};

/// A new one. Throws base::Error where the system gives no random bits.
Token draw_token();

std::string text_of(const Token& token);

/// None where the text is no token, or is not as it was given out.
std::optional<Token> token_of(std::string_view text);

/// Whether it could be the id of one.
bool is_token_id(std::string_view id);

/// What a service keeps: SHA-256 over id and secret, hexadecimal.
std::string hash_of(const Token& token);

/// In a time that does not tell where they differ.
bool are_equal_hashes(std::string_view a, std::string_view b);

}  // namespace sleight::access
