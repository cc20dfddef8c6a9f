// People's notes about animations: stars, tags, texts and hidden animations. Notes are never stored
// in archives.
//
// Each run has a JSON file <run>.json. The file is in a folder "sleight-notes" beside the run's
// archive if somebody created that folder to share notes. Otherwise the file is in
// $XDG_DATA_HOME/sleight/notes (default ~/.local/share/sleight/notes), readable only by its owner.
// A file is written under a temporary name and renamed, and is read again after another gallery has
// written it, so several galleries can share it. Notes that cannot be written, or whose run has an
// unreadable file, last until the program ends; `trouble` reports this.
//
// Thread safety: one lock guards everything.
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "clients/browse/archives/index_cache.h"
#include "common/json/value.h"

namespace sleight::gallery {

inline constexpr std::size_t k_note_bytes_max = 4000;
inline constexpr std::size_t k_tags_max = 32;
inline constexpr std::size_t k_tag_bytes_max = 100;
/// Per run.
inline constexpr std::size_t k_notes_max = 20'000;

class Notes {
 public:
  /// `folder`: default folder for files; empty: none.
  explicit Notes(std::string folder);

  /// Sets the folder of a run's file. Later calls for the same run have no effect.
  void keep_in(const std::string& run, const std::string& folder);
  /// All notes of a run, by animation; none if the file is unreadable.
  json::Value of_run(const std::string& run);
  /// Applies patches to some animations' notes. "star", "hidden" and "note" replace the old values.
  /// "tags_on" and "tags_off" add and remove tags. Other parts of a note stay, so that other
  /// people's changes aren't lost. Returns the complete new notes, each with "changed", which
  /// increases with each change of the run's notes. Throws base::Error(usage), without changes, if
  /// a patch is invalid or there would be too many notes.
  json::Value change(const std::string& run, const json::Value& patches);
  /// Why notes aren't stored; empty if notes are stored.
  std::string trouble() const;

 private:
  struct Run {
    json::Value notes = json::Value::object();
    std::optional<std::string> folder{};
    std::optional<browse::FileState> read{};  ///< the file's state when it was read or written
    bool is_unreadable = false;               ///< then the file isn't changed
  };
  Run& loaded(const std::string& run);
  const std::string& folder_of(const Run& run) const { return run.folder ? *run.folder : folder_; }
  std::string file_of(const std::string& run, const Run& known) const {
    return folder_of(known) + "/" + run + ".json";
  }
  void write(const std::string& run, Run& to);

  mutable std::mutex mutex_;
  std::string folder_;
  std::string trouble_;
  std::map<std::string, Run> runs_;
};

/// The folder for notes of this archive's run.
std::string notes_folder(const std::string& archive);

/// Whether `run` may be part of a file name: it has 1 to 128 letters and digits, nothing else.
bool is_run_word(const std::string& run);

}  // namespace sleight::gallery
