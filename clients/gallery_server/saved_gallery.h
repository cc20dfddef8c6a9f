// A gallery as a folder of static files, to publish on any web server or to open by double-click.
//
// A page opened as a file cannot fetch, so all data are scripts, which the page loads with script
// elements:
//
//   `index.html`, `app.js`, `app.css`: the page, built for saved galleries;
//   `data/gallery.js`: the answer of /api/gallery;
//   `data/A/NAME.js`: answers about archive A, where NAME is scene, looks, table, index, diagnosis,
//     series, series-NAME-CHAIN or animations-K (animations 32 K to 32 K + 31, in the table's
//     order);
//   `sleight-gallery.json`: the names of all these files.
//
// Each script calls sleightSaved(path, kind, text). Text of kind "json" is JSON; text of kind "gz"
// is base64 of the answer's bytes, compressed by gzip. Names of files are numbers and fixed words.
// Text from archives never becomes part of a name, and is in scripts only inside JSON strings.
//
// The folder is put in place as a whole (saved_folder.h). People's stars and notes are not saved.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "clients/analysis/diagnosis.h"
#include "clients/gallery_server/snapshot.h"
#include "common/base/error.h"

namespace sleight::gallery {

struct SavedArchive {
  std::string name{};  ///< the displayed name
  std::shared_ptr<const Snapshot> snapshot{};
};

struct SaveOptions {
  std::string folder{};  ///< new, empty, or a saved gallery to replace
  std::string page{};    ///< the folder of the built page
  std::string version{};
  /// Called after each file with the number of files written and the total number of files. If
  /// `progress` throws, the work ends and leaves nothing behind.
  std::function<void(std::size_t, std::size_t)> progress{};
};

/// Thrown if an archive turns out to be damaged while it is saved.
class UnreadableArchive : public base::Error {
 public:
  UnreadableArchive(std::size_t number, const std::string& words)
      : base::Error(base::ExitCode::bad_archive, words), number_(number) {}
  std::size_t number() const { return number_; }

 private:
  std::size_t number_;
};

/// Returns the number of bytes written. Throws base::Error (conflict if something else is in the
/// folder, environment if it cannot be written) and UnreadableArchive.
std::uint64_t save_gallery(const std::vector<SavedArchive>& archives, const SaveOptions& options,
                           const analysis::Rules& rules);

/// Encodes bytes as text for scripts (RFC 4648, section 4).
std::string base64(std::string_view bytes);

/// A script's line: sleightSaved("path", "json", "...").
std::string script_of(const std::string& path, const std::string& kind, const std::string& text);

}  // namespace sleight::gallery
