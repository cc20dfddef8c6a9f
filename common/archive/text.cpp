#include "common/archive/text.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace sleight::archive {
namespace {

constexpr char32_t k_broken = 0xFFFFFFFF;

/// Removes the first code point and returns it. Returns k_broken if the bytes are not UTF-8 (RFC
/// 3629).
char32_t take_code_point(std::string_view& text) {
  const auto lead = static_cast<std::uint8_t>(text.front());
  const std::size_t length = lead < 0x80   ? 1
                             : lead < 0xC0 ? 0
                             : lead < 0xE0 ? 2
                             : lead < 0xF0 ? 3
                             : lead < 0xF8 ? 4
                                           : 0;
  if (length == 0 || length > text.size()) return k_broken;
  char32_t point = length == 1 ? lead : lead & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    const auto byte = static_cast<std::uint8_t>(text[i]);
    if ((byte & 0xC0U) != 0x80) return k_broken;
    point = point << 6U | (byte & 0x3FU);
  }
  // Refuse code points that are overlong, half of a surrogate pair, or past the last code point.
  constexpr std::array<char32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};
  if (point < least[length] || (point >= 0xD800 && point < 0xE000) || point > 0x10FFFF) {
    return k_broken;
  }
  text.remove_prefix(length);
  return point;
}

bool is_clean(std::string_view text, bool lines) {
  while (!text.empty()) {
    const char32_t point = take_code_point(text);
    if (point == k_broken) return false;
    const bool control = point < 0x20 || (point >= 0x7F && point < 0xA0);
    if (control && !(lines && (point == '\n' || point == '\t'))) return false;
  }
  return true;
}

}  // namespace

bool is_clean_line(std::string_view text) {
  return is_clean(text, false);
}

bool is_clean_text(std::string_view text) {
  return is_clean(text, true);
}

}  // namespace sleight::archive
