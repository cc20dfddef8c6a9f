// The folder of a saved gallery: which files may be replaced, and how a new gallery replaces an old
// one.
//
// A saved gallery lists its files in its manifest, sleight-gallery.json:
//
//   {"about":"...", "sleight_gallery":1, "files":["app.css", ..., "sleight-gallery.json"]}.
//
// Invariants:
//
// 1. Only regular files listed in the present gallery's manifest are replaced or removed. A folder
//    with any other content is refused and not changed. A manifest with names that no saved gallery
//    writes is ignored.
// 2. The new gallery is written into a separate folder, and put in place when it is complete. Old
//    and new files are exchanged by renames; if a rename fails, all renames are undone.
// 3. An existing folder stays the same folder, because it may be a mount point, the target of a
//    link, or a shell's current folder. So the new gallery is first written inside an existing
//    folder, or beside a new folder.
//
// A killed process leaves a folder ".sleight-saving-...". The program never removes such a folder,
// because it may contain the old gallery.
//
// Not thread-safe. If two processes save into one folder at once, at least one of them is refused.
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
  /// Checks the place and creates the folder to write into. Links are followed. Throws
  /// filesystem_error, or base::Error: conflict if the place has other content, otherwise
  /// environment.
  explicit SavedFolder(const std::string& folder);
  ~SavedFolder();  ///< removes written files that aren't in place
  SavedFolder(const SavedFolder&) = delete;
  SavedFolder& operator=(const SavedFolder&) = delete;

  /// Returns the number of bytes. REQUIRES: the name is "index.html", "app.js", "app.css" or
  /// "data/....js". Throws as the constructor.
  std::uint64_t write(const std::string& name, std::string_view content);

  /// Writes the manifest, puts all files in place, and returns the manifest's size in bytes. Throws
  /// like the constructor. After an exception, the old gallery is unchanged, or the error names its
  /// location.
  /// REQUIRES: called once.
  std::uint64_t put_in_place();

 private:
  void exchange();
  void remove_old();

  std::filesystem::path place_;
  bool is_new_;
  std::filesystem::path work_;      ///< the working folder, with new/ and old/
  std::set<std::string> written_;   ///< files of the new gallery
  std::set<std::string> replaced_;  ///< files of the old gallery
};

}  // namespace sleight::gallery
