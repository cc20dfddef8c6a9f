// The archives that a page shows: which exist, what has been read, and changes.
//
// A thread checks the files several times a second. How an archive is shown depends on its history:
//  - Read before: the stored outline is shown at once. Motions are read two seconds later or when
//    requested, so that the page can first use the processor for loading.
//  - Read for the first time, with many animations: the first 500 are shown while the others are
//    read.
//  - Replaced: the new file is read while the old snapshot stays visible.
//  - Missing or damaged: what was read stays visible, with a message.
//
// Folders are checked for new archives (listed_files.h).
//
// Thread safety: all functions may be called from any thread. `changed` is called from the checking
// thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "clients/gallery_server/listed_files.h"
#include "clients/gallery_server/snapshot.h"
#include "common/json/value.h"

namespace sleight::gallery {

enum class ArchiveState : std::uint8_t { reading, ready, gone, damaged };

struct GalleryOptions {
  std::vector<std::string> paths{};  ///< archives and folders of archives
  double look_every_s = 0.25;
  /// Called when the result of state() has changed.
  std::function<void()> changed{};
  Opener open{};  ///< none: archive::remote::open_remote
};

class Gallery {
 public:
  /// Starts the checking thread, which reads the archives.
  explicit Gallery(GalleryOptions options);
  ~Gallery();
  Gallery(const Gallery&) = delete;
  Gallery& operator=(const Gallery&) = delete;

  /// The answer of /api/gallery, without the notes.
  json::Value state() const;

  /// The archive's snapshot; null if nothing has been read (yet), or the archive doesn't exist.
  std::shared_ptr<const Snapshot> snapshot(std::size_t archive) const;
  /// The archive's snapshot, if it has motions. If there is only an outline, waits up to 2 s for
  /// the motions, then returns null.
  std::shared_ptr<const Snapshot> whole_snapshot(std::size_t archive) const;
  /// Why a damaged or missing archive cannot be read, as sentences; else empty.
  std::string why_unreadable(std::size_t archive) const;
  std::size_t archives() const;
  /// The archive's file, for messages; empty if the archive doesn't exist.
  std::string path_of(std::size_t archive) const;

  /// Sets the status of a run that is in progress elsewhere; `words` are for people.
  void set_live(const std::string& path, bool is_live, const std::string& words);

 private:
  struct Shown {
    std::string path{};
    std::string name{};
    ArchiveState state = ArchiveState::reading;
    std::string words{};
    std::uint64_t read = 0;  ///< animations read so far, while reading
    std::uint64_t of = 0;
    bool is_live = false;
    std::string live_words{};
    std::shared_ptr<const Snapshot> snapshot{};
    /// The last file that was tried; a file isn't tried again unless it changes.
    std::optional<browse::FileState> tried{};
    /// For an outline: when it was first shown, and whether motions were requested.
    std::chrono::steady_clock::time_point outlined_at{};
    bool is_wanted = false;
    bool has_outline() const { return snapshot && snapshot->is_outline(); }
    /// Whether motions can be read: the file exists and has had no errors.
    bool may_become_whole() const { return has_outline() && state == ArchiveState::ready; }
  };
  void look_forever();
  void look_through_folders();
  void look_at(std::size_t archive);
  /// The file to read, and the snapshot that is shown meanwhile.
  struct Reading {
    std::string path{};
    browse::FileState file{};
    std::shared_ptr<const Snapshot> before{};
    /// The outline shown for this file; the whole snapshot has the same generation.
    std::shared_ptr<const Snapshot> outline{};
  };
  /// Shows the file's stored outline, if there is one; returns whether there was one.
  bool show_outline(std::size_t archive, const Reading& reading);
  /// Throws what Snapshot's constructor throws.
  std::shared_ptr<const Snapshot> read(std::size_t archive, const Reading& reading,
                                       std::uint64_t beginning_max);
  std::uint64_t new_generation();
  /// Shows a snapshot, or the fault if the snapshot is null.
  void show(std::size_t archive, std::shared_ptr<const Snapshot> now, const std::string& fault);
  void tell();

  GalleryOptions options_;
  mutable std::mutex mutex_;  ///< guards all members below
  std::vector<std::unique_ptr<Shown>> shown_;
  std::vector<ListedFiles::LeftOut> left_out_;
  /// Starts at the present time in milliseconds, so that a page that stays open during a restart
  /// doesn't confuse generations.
  std::uint64_t generation_;
  bool is_over_ = false;
  mutable std::condition_variable changed_;  ///< on the end, snapshots, requests for motions
  std::thread looking_;
};

}  // namespace sleight::gallery
