// Encodes bytes as base64 text for scripts (RFC 4648, section 4).
#pragma once

#include <string>
#include <string_view>

namespace sleight::gallery {

std::string base64(std::string_view bytes);

}  // namespace sleight::gallery
