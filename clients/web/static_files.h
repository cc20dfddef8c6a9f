// The files of a page, read into memory once.
//
// A request's path is looked up among the names found at the start, so it never reaches the file
// system. Files with an unknown extension, and files whose names begin with a dot, are not part of
// the page.
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

/// Limits of a page's folder; larger folders are refused.
inline constexpr std::size_t k_static_files_max = 1000;
inline constexpr std::size_t k_static_bytes_max = 64U << 20U;
inline constexpr int k_static_depth_max = 8;

class StaticFiles {
 public:
  /// Reads a folder and its subfolders. Throws base::Error if the folder is unreadable, has no
  /// index.html, or contains anything but files and folders: a link might lead elsewhere.
  explicit StaticFiles(const std::string& folder);

  /// The file for "/assets/index-3f2a9c01.js", for example, or index.html for "/". The file is
  /// compressed if the browser accepts gzip and gzip makes the file shorter.
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

  std::map<std::string, File, std::less<>> files_;  ///< by path, including the first slash
};

/// Returns the Content-Type for a file's extension (html js css svg png wasm json woff2), otherwise
/// none.
std::optional<std::string_view> type_of(std::string_view name);

/// Whether a name contains its content's hash, as Vite writes it: index-DkX3_9aQ.js. Before the
/// extension, the name must end with '-' or '.' and eight base64url characters, of which at least
/// one is a digit or capital.
bool has_hash(std::string_view name);

}  // namespace sleight::web
