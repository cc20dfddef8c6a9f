// What people say of animations: stars, tags, notes, hidden ones. Never in an archive.
//
// One JSON file a run, called <run>.json: in a folder "sleight-notes" beside the run's archive if
// that folder is there (made by somebody who wants to share notes), else in
// $XDG_DATA_HOME/sleight/notes (else ~/.local/share/sleight/notes), a folder that its owner alone
// can read. A file is written beside its place and renamed; it is read again when somebody else has
// written it, so that several galleries may share it. What can't be written, or belongs to a run
// whose file can't be read, is kept until the program ends, and `trouble` says so.
//
// Thread safety: one lock for all.
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
/// Of one run.
inline constexpr std::size_t k_notes_max = 20'000;

class Notes {
 public:
  /// `folder`: where files are kept of runs of which nothing else is said; empty: nowhere.
  explicit Notes(std::string folder);

  /// A run's file is kept there; of a run of which that was said before nothing changes.
  void keep_in(const std::string& run, const std::string& folder);
  /// All of a run, by animation. A file that can't be read has none.
  json::Value of_run(const std::string& run);
  /// Changes those of some animations, each as its patch says: "star", "hidden" and "note" are what
  /// they are then, "tags_on" and "tags_off" are added and taken off; what it doesn't speak of
  /// stays, so that others' changes do. Returns the whole notes as they are now, each with
  /// "changed", which grows with each change of the run's notes. Throws base::Error(usage), and
  /// changes nothing, where one is no patch, or the notes become too much.
  json::Value change(const std::string& run, const json::Value& patches);
  /// Why notes aren't kept; empty: they are.
  std::string trouble() const;

 private:
  struct Run {
    json::Value notes = json::Value::object();
    std::optional<std::string> folder{};
    std::optional<browse::FileState> read{};  ///< the file's state when it was read or written
    bool is_unreadable = false;               ///< then the file is left as it is
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

/// Where notes of this archive's run are kept.
std::string notes_folder(const std::string& archive);

/// True of what may be a run's name in a file's: letters and digits.
bool is_run_word(const std::string& run);

}  // namespace sleight::gallery
