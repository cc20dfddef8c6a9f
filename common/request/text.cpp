#include "common/request/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "common/base/check.h"

namespace sleight::request {
namespace {

constexpr double k_radians_per_degree = 0.017453292519943295;  // pi / 180, rounded once

/// Returns whether the character is a control character, or can make a terminal reorder or hide
/// text.
bool is_unprintable(char32_t c) {
  return c < 0x20 || (c >= 0x7f && c <= 0x9f)  // C0, DEL, C1
         || c == 0xad || c == 0x61c            // soft hyphen, Arabic letter mark
         || (c >= 0x200b && c <= 0x200f)       // zero width, direction marks
         || (c >= 0x2028 && c <= 0x202e)       // separators, embeddings, overrides
         || (c >= 0x2060 && c <= 0x206f)       // invisible operators, isolates
         || c == 0xfeff                        // byte order mark
         || (c >= 0xfff0 && c <= 0xffff)       // specials
         || (c >= 0xe0000 && c <= 0xe0fff);    // tags
}

}  // namespace

std::optional<CodePoint> front_code_point(std::string_view text) {
  CHECK(!text.empty());
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return CodePoint{lead, 1};

  // The lead byte determines the length and the smallest code point that needs this length.
  std::size_t bytes = 0;
  char32_t least = 0;
  char32_t value = 0;
  if ((lead & 0xe0) == 0xc0) {
    bytes = 2, least = 0x80, value = lead & 0x1fU;
  } else if ((lead & 0xf0) == 0xe0) {
    bytes = 3, least = 0x800, value = lead & 0x0fU;
  } else if ((lead & 0xf8) == 0xf0) {
    bytes = 4, least = 0x10000, value = lead & 0x07U;
  } else {
    return std::nullopt;
  }
  if (text.size() < bytes) return std::nullopt;
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return std::nullopt;
    value = (value << 6) | (byte(i) & 0x3fU);
  }
  const bool surrogate = value >= 0xd800 && value <= 0xdfff;
  if (value < least || value > 0x10ffff || surrogate) return std::nullopt;
  return CodePoint{value, bytes};
}

std::size_t character_count(std::string_view text) {
  // Every character has exactly one byte that is not a continuation byte (10xxxxxx).
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

std::string printable(std::string_view text, std::size_t characters_max) {
  std::string shown;
  for (std::size_t characters = 0; !text.empty(); ++characters) {
    if (characters == characters_max) return shown + "...";
    const std::optional<CodePoint> c = front_code_point(text);
    const std::size_t bytes = c ? c->bytes : 1;
    if (!c) {
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
    } else if (is_unprintable(c->value)) {
      shown += fmt::format("\\u{{{:x}}}", static_cast<std::uint32_t>(c->value));
    } else {
      shown += text.substr(0, bytes);
    }
    text.remove_prefix(bytes);
  }
  return shown;
}

std::string plain_number(double value) {
  std::string digits = fmt::format("{}", value);
  // Shorten 1e-06 to 1e-6.
  const std::size_t exponent = digits.find("e-0");
  if (exponent != std::string::npos) digits.erase(exponent + 2, 1);
  return digits;
}

std::string toml_number(double value) {
  CHECK(std::isfinite(value));
  std::string digits = plain_number(value);
  if (digits.find_first_of(".e") == std::string::npos) digits += ".0";
  return digits;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::optional<CodePoint> c = front_code_point(text);
    if (!c) return false;
    text.remove_prefix(c->bytes);
  }
  return true;
}

std::string toml_string(std::string_view text) {
  std::string quoted = "\"";
  while (!text.empty()) {
    const std::optional<CodePoint> c = front_code_point(text);
    CHECK(c.has_value());
    if (c->value == '"' || c->value == '\\') {
      quoted += '\\';
      quoted += static_cast<char>(c->value);
    } else if (is_unprintable(c->value)) {
      quoted += fmt::format("\\U{:08X}", static_cast<std::uint32_t>(c->value));
    } else {
      quoted += text.substr(0, c->bytes);
    }
    text.remove_prefix(c->bytes);
  }
  return quoted + '"';
}

double radians_of_degrees(double degrees) {
  return degrees * k_radians_per_degree;
}

double degrees_of_radians(double radians) {
  CHECK(std::isfinite(radians));
  const double nearest = radians / k_radians_per_degree;
  for (int digits = 1; digits <= 17; ++digits) {
    const std::string text = fmt::format("{:.{}g}", nearest, digits);
    double degrees = 0;
    std::from_chars(text.data(), text.data() + text.size(), degrees);
    if (radians_of_degrees(degrees) == radians) return degrees;
  }
  return nearest;
}

}  // namespace sleight::request
