#include "clients/gallery_server/base64.h"

#include <cstddef>
#include <cstdint>

namespace sleight::gallery {

std::string base64(std::string_view bytes) {
  constexpr std::string_view k_digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  constexpr std::size_t k_group = 3;
  constexpr std::uint32_t k_six_bits = 63;
  std::string text;
  text.reserve((bytes.size() + 2) / k_group * 4);
  for (std::size_t first = 0; first < bytes.size(); first += k_group) {
    const std::string_view group = bytes.substr(first, k_group);
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < k_group; ++i)
      bits = bits << 8U | (i < group.size() ? static_cast<std::uint8_t>(group[i]) : 0U);
    for (std::size_t digit = 0; digit < 4; ++digit) {
      text += digit <= group.size() ? k_digits[bits >> (18U - 6U * digit) & k_six_bits] : '=';
    }
  }
  return text;
}

}  // namespace sleight::gallery
