#include "common/access/token_text.h"

#include <openssl/crypto.h>
#include <sys/random.h>

#include <span>

#include "common/base/error.h"
#include "common/hash/sha256.h"

namespace sleight::access {
namespace {

constexpr std::string_view k_digits = "0123456789abcdefghjkmnpqrstvwxyz";
constexpr unsigned k_digit_bits = 5;
constexpr std::size_t k_secret_characters = 52;  // 260 bits, of which the last four are 0
constexpr std::size_t k_check_characters = 7;

/// Encodes `bytes` in base 32 and returns the first `characters` characters.
std::string base32_of(std::span<const std::byte> bytes, std::size_t characters) {
  std::string text;
  for (std::size_t i = 0; i < characters; ++i) {
    unsigned digit = 0;
    for (unsigned bit = 0; bit < k_digit_bits; ++bit) {
      const std::size_t at = k_digit_bits * i + bit;
      const bool is_set = at / 8 < bytes.size() &&
                          ((std::to_integer<unsigned>(bytes[at / 8]) >> (7 - at % 8)) & 1U) != 0;
      digit = 2 * digit + (is_set ? 1U : 0U);
    }
    text += k_digits[digit];
  }
  return text;
}

std::string check_of(std::string_view id, std::string_view secret) {
  const std::string text =
      std::string("check of a token of Sleight's: ").append(id).append("_").append(secret);
  const hash::Sha256::Value hash = hash::sha256_of(std::as_bytes(std::span(text)));
  return base32_of(hash, k_check_characters);
}

void fill_randomly(std::span<std::byte> bytes) {
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw base::Error("the system returned no random numbers");
}

}  // namespace

Token draw_token() {
  Token token;
  std::array<std::byte, 7> id{};
  fill_randomly(id);
  fill_randomly(token.secret);
  token.id = base32_of(id, k_token_id_characters);
  return token;
}

std::string text_of(const Token& token) {
  const std::string secret = base32_of(token.secret, k_secret_characters);
  return std::string(k_token_prefix)
      .append(token.id)
      .append("_")
      .append(secret)
      .append(check_of(token.id, secret));
}

bool is_token_id(std::string_view id) {
  return id.size() == k_token_id_characters &&
         id.find_first_not_of(k_digits) == std::string_view::npos;
}

std::optional<Token> token_of(std::string_view text) {
  if (text.size() != k_token_characters || !text.starts_with(k_token_prefix)) return std::nullopt;
  text.remove_prefix(k_token_prefix.size());
  Token token{.id = std::string(text.substr(0, k_token_id_characters))};
  if (!is_token_id(token.id) || text[k_token_id_characters] != '_') return std::nullopt;
  const std::string_view secret = text.substr(k_token_id_characters + 1, k_secret_characters);
  for (std::size_t i = 0; i < secret.size(); ++i) {
    const std::size_t digit = k_digits.find(secret[i]);
    if (digit == std::string_view::npos) return std::nullopt;
    for (unsigned bit = 0; bit < k_digit_bits; ++bit) {
      const std::size_t at = k_digit_bits * i + bit;
      const bool is_set = ((digit >> (k_digit_bits - 1 - bit)) & 1U) != 0;
      if (!is_set) continue;
      if (at / 8 >= token.secret.size()) return std::nullopt;
      token.secret[at / 8] |= static_cast<std::byte>(1U << (7 - at % 8));
    }
  }
  if (text.substr(k_token_id_characters + 1 + k_secret_characters) != check_of(token.id, secret))
    return std::nullopt;
  return token;
}

std::string hash_of(const Token& token) {
  hash::Sha256 hash;
  hash.update(std::string_view("token of Sleight's\n"));
  hash.update(std::string_view(token.id));
  hash.update(std::span<const std::byte>(token.secret));
  return hash::to_hex(hash.finish());
}

bool are_equal_hashes(std::string_view a, std::string_view b) {
  return a.size() == b.size() && ::CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace sleight::access
