// A gallery as a folder of static files: to publish on any web server, and to open by double-click.
//
// A page that is opened as a file may fetch nothing, so all data come as scripts that the page asks
// for by script elements:
//
//   index.html, app.js, app.css    the page, built for this
//   data/gallery.js                what /api/gallery answers
//   data/A/NAME.js                 what is answered of archive A: scene, looks, table, index,
//                                  diagnosis, series, series-NAME-CHAIN, animations-K: animations
//                                  32 K to 32 K + 31 of the table, in its order
//   sleight-gallery.json           the names of all these files
//
// Each script calls sleightSaved(path, kind, text) with kind "json" and a JSON text, or "gz" and
// the answer's bytes, compressed by gzip, as base64. Names of files are numbers and plain words;
// nothing in an archive gets into one, nor into a script but inside a string of JSON.
//
// The folder is put in place as a whole (saved_folder.h). Stars and notes are a person's own and
// don't go along.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "clients/analysis/diagnosis.h"
#include "clients/gallery_server/snapshot.h"
#include "common/base/error.h"

namespace sleight::gallery {

struct SavedArchive {
  std::string name{};  ///< as people see it
  std::shared_ptr<const Snapshot> snapshot{};
};

struct SaveOptions {
  std::string folder{};  ///< where it is to be: new, empty, or a saved gallery, which is replaced
  std::string page{};    ///< the folder of the built page (page_folder.h)
  std::string version{};
  /// Told after each file: files that are written, of how many. What it throws ends the work and
  /// leaves nothing behind.
  std::function<void(std::size_t, std::size_t)> progress{};
};

/// One of the archives turned out to be damaged while it was read.
class UnreadableArchive : public base::Error {
 public:
  UnreadableArchive(std::size_t number, const std::string& words)
      : base::Error(base::ExitCode::bad_archive, words), number_(number) {}
  std::size_t number() const { return number_; }

 private:
  std::size_t number_;
};

/// Returns the bytes that were written. Throws base::Error: conflict where something else is in the
/// folder, environment where it can't be written; UnreadableArchive.
std::uint64_t save_gallery(const std::vector<SavedArchive>& archives, const SaveOptions& options,
                           const analysis::Rules& rules);

/// A script's line: sleightSaved("path", "json", "...").
std::string script_of(const std::string& path, const std::string& kind, const std::string& text);

}  // namespace sleight::gallery
