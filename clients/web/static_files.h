// The files of a page, read into memory once.
//
// A request's path is looked up among the names that were found at the start, so that it never
// reaches the file system. Files whose extension has no type here, and those with a name that
// begins with a dot, are no part of the page.
//
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "clients/web/ask.h"

namespace sleight::web {

/// A page beyond these is none of ours.
inline constexpr std::size_t k_static_files_max = 1000;
inline constexpr std::size_t k_static_bytes_max = 64U << 20U;
inline constexpr int k_static_depth_max = 8;

class StaticFiles {
 public:
  /// Reads a folder and those in it. Throws base::Error where it can't be read, or holds no
  /// index.html, or anything that is neither file nor folder: a link might lead elsewhere.
  explicit StaticFiles(const std::string& folder);

  /// Of "/assets/index-3f2a9c01.js", or of "/", which is index.html. Compressed where that is
  /// accepted and shorter.
  std::optional<Answer> find(std::string_view path, bool accepts_gzip) const;

  std::size_t count() const { return files_.size(); }

 private:
  struct File {
    std::string type{};
    std::string etag{};
    Cache cache = Cache::no_store;
    Content plain{};
    std::optional<Content> compressed{};
  };
  struct Reading;

  std::map<std::string, File, std::less<>> files_;  ///< by path, with its first slash
};

/// The Content-Type of a file's name, or none: html js css svg png wasm json woff2.
std::optional<std::string_view> type_of(std::string_view name);

/// Whether its content's hash is part of a name, as Vite writes it: index-DkX3_9aQ.js. Nine
/// characters of the name's end: '-' or '.', and eight of base64url, one of them a digit or
/// capital.
bool has_hash(std::string_view name);

}  // namespace sleight::web
