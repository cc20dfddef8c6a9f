// The folder of a saved gallery: what in it may be replaced, and how a new gallery takes the place
// of the one that is there.
//
// A saved gallery names its files in its manifest, sleight-gallery.json:
//
//   {"about": "...", "sleight_gallery": 1, "files": ["app.css", ..., "sleight-gallery.json"]}
//
// Invariants:
// 1. Only regular files that the manifest of the gallery there names are replaced or removed. A
//    folder with anything else in it is refused, and left as it is. A manifest that names what no
//    saved gallery writes is none.
// 2. The new gallery is written into a folder with a name of its own, and put in place once it is
//    whole. Its files and the old ones change places by renames; if one fails all are taken back.
// 3. A folder that was there stays that folder: it may be a mount point, the place where a link
//    leads, or some shell's current folder. Therefore the new gallery is written in it; where there
//    is none yet, beside its place.
//
// Of a process that is killed a folder ".sleight-saving-..." stays; it is never removed unasked, as
// it may hold the old gallery.
//
// Not thread-safe; two that save into one folder refuse each other.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

namespace sleight::gallery {

inline constexpr std::string_view k_manifest = "sleight-gallery.json";

class SavedFolder {
 public:
  /// Looks at the place and makes the folder to write into. Links are followed. Throws base::Error:
  /// conflict where something else is there, environment; and filesystem_error.
  explicit SavedFolder(const std::string& folder);
  ~SavedFolder();  ///< takes away what was written and isn't in place
  SavedFolder(const SavedFolder&) = delete;
  SavedFolder& operator=(const SavedFolder&) = delete;

  /// Returns its bytes. REQUIRES: "index.html", "app.js", "app.css" or "data/....js". Throws as the
  /// constructor.
  std::uint64_t write(const std::string& name, std::string_view content);

  /// Writes the manifest, whose bytes it returns, and puts all in place. Throws as the constructor;
  /// then the old gallery is as it was, or the error says where it is. REQUIRES: called once.
  std::uint64_t put_in_place();

 private:
  void exchange();
  void remove_old();

  std::filesystem::path place_;
  bool is_new_;
  std::filesystem::path work_;      ///< the folder of our own: new/ and old/
  std::set<std::string> written_;   ///< files of the new gallery
  std::set<std::string> replaced_;  ///< of the one there
};

}  // namespace sleight::gallery
