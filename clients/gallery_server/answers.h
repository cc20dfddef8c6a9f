// Answers the page's requests, by path. docs/GALLERY.md lists all paths.
//
// The sender has passed the guard (clients/web), but the request's contents are untrusted. Requests
// name archives by number and animations by name; both are looked up in the data read so far.
// Request bodies are JSON, which is checked.
//
// Thread safety: all functions may be called from any thread.
#pragma once

#include <string>
#include <vector>

#include "clients/analysis/diagnosis.h"
#include "clients/gallery_server/gallery.h"
#include "clients/gallery_server/notes.h"
#include "clients/web/ask.h"

namespace sleight::gallery {

class Answers {
 public:
  /// All references must outlive the object. `rules`: the rules by which chains are diagnosed.
  Answers(const Gallery& gallery, Notes& notes, const analysis::Rules& rules, std::string version)
      : gallery_(gallery), notes_(notes), rules_(rules), version_(std::move(version)) {}

  web::Answer operator()(const web::Ask& ask) const;

  /// The answer of /api/gallery as text; events contain the same text.
  std::string gallery_text() const;

 private:
  web::Answer get(const web::Ask& ask) const;
  web::Answer post(const web::Ask& ask) const;
  web::Answer of_archive(const web::Ask& ask, std::size_t archive, std::string_view what) const;
  /// Returns the runs of the archives shown, and sets the folder of each run's notes.
  std::vector<std::string> runs_with_notes() const;
  web::Answer notes_answer() const;

  const Gallery& gallery_;
  Notes& notes_;
  const analysis::Rules& rules_;
  std::string version_;
};

}  // namespace sleight::gallery
