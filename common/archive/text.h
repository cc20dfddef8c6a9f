// Checks text in archives. The text is shown on terminals and written as JSON; stray bytes would do
// harm there.
#pragma once

#include <string_view>

namespace sleight::archive {

/// Returns whether the text is valid UTF-8 without control characters (C0, DEL, C1).
bool is_clean_line(std::string_view text);

/// Like is_clean_line, but also permits line ends and tabs, as in requests.
bool is_clean_text(std::string_view text);

}  // namespace sleight::archive
