// Checks text in archives, which reaches terminals and JSON, where stray bytes do harm.
#pragma once

#include <string_view>

namespace sleight::archive {

/// True for valid UTF-8 without control characters (C0, DEL, C1).
bool is_clean_line(std::string_view text);

/// True for such text with line ends and tabs, as in requests.
bool is_clean_text(std::string_view text);

}  // namespace sleight::archive
