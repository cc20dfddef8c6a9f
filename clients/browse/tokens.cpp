#include "clients/browse/tokens.h"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace sleight::browse {
namespace {

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

class Lexer {
 public:
  explicit Lexer(std::string_view text) : text_(text) {}

  base::Result<std::vector<Token>, QueryError> all() {
    if (text_.size() > k_query_bytes_max)
      return QueryError{
          .column = k_query_bytes_max,
          .message = fmt::format("the query is longer than {} bytes", k_query_bytes_max)};
    while (true) {
      const std::size_t before = at_;
      while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n'))
        ++at_;
      Token token{.column = at_, .is_joined = at_ == before && !tokens_.empty()};
      if (at_ == text_.size()) {
        tokens_.push_back(token);
        return std::move(tokens_);
      }
      if (const auto error = read(token)) return *error;
      tokens_.push_back(std::move(token));
    }
  }

 private:
  char peek(std::size_t ahead) const {
    return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
  }

  std::optional<QueryError> read(Token& token) {
    const char c = peek(0);
    if (is_letter(c)) return read_word(token);
    if (c == '"') return read_quoted(token);
    const bool is_signed = (c == '-' || c == '+');
    const char first = is_signed ? peek(1) : c;
    const char second = is_signed ? peek(2) : peek(1);
    if (is_digit(first) || (first == '.' && is_digit(second))) return read_number(token);
    return read_sign(token);
  }

  std::optional<QueryError> read_word(Token& token) {
    const std::size_t begin = at_;
    while (is_letter(peek(0)) || is_digit(peek(0)))
      ++at_;
    // The only sign within a unit is the slash in units such as "mm/s".
    const std::string_view word = text_.substr(begin, at_ - begin);
    if (peek(0) == '/' && is_letter(peek(1)) && (word == "m" || word == "mm")) {
      ++at_;
      while (is_letter(peek(0)))
        ++at_;
    }
    token.kind = Token::Kind::word;
    token.text = text_.substr(begin, at_ - begin);
    return std::nullopt;
  }

  std::optional<QueryError> read_quoted(Token& token) {
    token.kind = Token::Kind::quoted;
    for (++at_; at_ < text_.size(); ++at_) {
      if (text_[at_] == '"') {
        ++at_;
        return std::nullopt;
      }
      if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
      token.text += text_[at_];
    }
    return QueryError{.column = token.column, .message = "the closing quote is missing"};
  }

  std::optional<QueryError> read_number(Token& token) {
    // "0..20" is 0, then "..". A point belongs to the number if a digit follows, or if no second
    // point follows.
    const std::size_t begin = at_;
    if (peek(0) == '-' || peek(0) == '+') ++at_;
    const std::size_t digits = at_;
    while (is_digit(peek(0)))
      ++at_;
    if (peek(0) == '.' && peek(1) != '.') {
      ++at_;
      while (is_digit(peek(0)))
        ++at_;
    }
    const bool is_exponent =
        (peek(0) == 'e' || peek(0) == 'E') &&
        (is_digit(peek(1)) || ((peek(1) == '-' || peek(1) == '+') && is_digit(peek(2))));
    if (is_exponent) {
      at_ += 2;
      while (is_digit(peek(0)))
        ++at_;
    }
    token.kind = Token::Kind::number;
    token.text = text_.substr(begin, at_ - begin);
    const char* end = text_.data() + at_;
    const auto [stop, failure] = std::from_chars(text_.data() + digits, end, token.number);
    if (failure != std::errc{} || stop != end || !std::isfinite(token.number)) {
      return QueryError{
          .column = begin,
          .message = fmt::format("the number '{}' is too large or too small", token.text)};
    }
    if (text_[begin] == '-') token.number = -token.number;
    return std::nullopt;
  }

  std::optional<QueryError> read_sign(Token& token) {
    constexpr std::array<std::string_view, 12> k_signs{"..", "<=", ">=", "<", ">", "=",
                                                       "(",  ")",  ":",  ",", "[", "]"};
    for (const std::string_view sign : k_signs) {
      if (!text_.substr(at_).starts_with(sign)) continue;
      token.kind = Token::Kind::sign;
      token.text = sign;
      at_ += sign.size();
      return std::nullopt;
    }
    const bool is_printable = text_[at_] > ' ' && text_[at_] < '\x7f';
    return QueryError{.column = at_,
                      .message = is_printable ? fmt::format("unexpected character '{}'", text_[at_])
                                              : std::string("unexpected character")};
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::vector<Token> tokens_{};
};

}  // namespace

base::Result<std::vector<Token>, QueryError> tokens_of(std::string_view text) {
  return Lexer(text).all();
}

}  // namespace sleight::browse
