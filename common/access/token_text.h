// Access tokens as text that people can copy. Clients log in over TCP with a token.
//
//   sleight_7k2m9q4x1c_<52 characters: 256 random bits><7 characters: check>
//
// The prefix lets secret scanners recognise a token. The id names the token in lists and logs and
// is not secret. The check detects typing errors and truncation before the token is sent.
// Characters are Crockford's base 32 in lower case.
//
// A service stores only a token's hash. All bits of the secret are random, so a plain SHA-256 is
// sufficient.
//
// Thread safety: pure functions, except `draw_token`, which gets random bits from the system.
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
inline constexpr std::size_t k_token_characters =
    k_token_prefix.size() + k_token_id_characters + 1 + 52 + 7;

struct Token {
  std::string id{};
  std::array<std::byte, k_token_secret_bytes> secret{};
};

/// Returns a new token. Throws base::Error if the system has no random bits.
Token draw_token();

std::string text_of(const Token& token);

/// Returns nothing if the text is not a token or was changed.
std::optional<Token> token_of(std::string_view text);

/// Returns whether the text has the form of a token's id.
bool is_token_id(std::string_view id);

/// Returns the hash that a service stores: the SHA-256 of id and secret, in hexadecimal.
std::string hash_of(const Token& token);

/// Compares two hashes in a time that does not depend on where they differ.
bool are_equal_hashes(std::string_view a, std::string_view b);

}  // namespace sleight::access
