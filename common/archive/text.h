// What text an archive may hold: it reaches terminals and JSON, where stray bytes do harm.
#pragma once

#include <string_view>

namespace sleight::archive {

/// Valid UTF-8 without control characters (C0, DEL, C1).
bool is_clean_line(std::string_view text);

/// The same, with line ends and tabs: requests.
bool is_clean_text(std::string_view text);

}  // namespace sleight::archive
