// What the page is answered, by path. docs/GALLERY.md lists all of it.
//
// Whoever asks has passed the guard (clients/web); what is asked may still be anything: archives go
// by number and animations by name, both looked up in what was read, and bodies are JSON that is
// checked.
//
// Thread safety: all functions may be called from any thread.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "clients/analysis/diagnosis.h"
#include "clients/gallery_server/gallery.h"
#include "clients/gallery_server/notes.h"
#include "clients/web/ask.h"

namespace sleight::gallery {

class Answers {
 public:
  /// All must outlive it. `rules`: by which chains are judged.
  Answers(const Gallery& gallery, Notes& notes, const analysis::Rules& rules, std::string version)
      : gallery_(gallery), notes_(notes), rules_(rules), version_(std::move(version)) {}

  web::Answer operator()(const web::Ask& ask) const;

  /// What /api/gallery answers, as text: an event says the same.
  std::string gallery_text() const;

 private:
  web::Answer get(const web::Ask& ask) const;
  web::Answer post(const web::Ask& ask) const;
  web::Answer of_archive(const web::Ask& ask, std::size_t archive, std::string_view what) const;
  /// Of the archives that are shown; says where the notes of each are kept.
  std::vector<std::string> runs_with_notes() const;
  web::Answer notes_answer() const;

  const Gallery& gallery_;
  Notes& notes_;
  const analysis::Rules& rules_;
  std::string version_;
};

}  // namespace sleight::gallery
