// Files whose content is replaced atomically.
//
// Thread safety: calls for different files are independent.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/file_system.h"

namespace sleight::base {

enum class Readers : std::uint8_t {
  usual,  ///< according to the process's umask
  owner   ///< only the owner, from the first byte
};

/// Like write_text_file, but atomic and durable: writes a temporary file, syncs and renames it.
/// Removes leftovers of earlier tries. Throws base::Error; the old content then remains.
void replace_text_file(FileSystem& files, const std::string& path, std::string_view text,
                       Readers readers = Readers::usual);

}  // namespace sleight::base
