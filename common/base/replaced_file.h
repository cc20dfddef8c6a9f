// Files whose content is replaced in one step.
//
// Thread safety: calls for different files are independent.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/file_system.h"

namespace sleight::base {

/// Who may read a file that is made.
enum class Readers : std::uint8_t {
  usual,  ///< as the process's umask has it
  owner   ///< from its first byte on
};

/// As write_text_file, but in one step and durable: written beside it, synced and renamed. What an
/// earlier try left beside it goes. Throws base::Error; then the old content stands.
void replace_text_file(FileSystem& files, const std::string& path, std::string_view text,
                       Readers readers = Readers::usual);

}  // namespace sleight::base
