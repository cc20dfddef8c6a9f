// The archives that a page shows: which there are, what has been read of them, and how that
// changes.
//
// A thread looks at the files some times a second. Of one that was browsed before, what was kept is
// shown at once, and the motions are read two seconds later or when they are asked for: the
// processor is left to the page that is being loaded. Of one that is read for the first time, and
// has many animations, the first 500 are shown while the others are read. One that was replaced is
// read anew beside the old snapshot, which is shown until the new one is whole; one that is gone or
// damaged keeps what was read of it, and says so. Folders are looked through for new archives
// (listed_files.h).
//
// Thread safety: all functions may be called from any thread. `changed` is called from the looking
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
  /// Something that `state` says has changed.
  std::function<void()> changed{};
  Opener open{};  ///< none: archive::remote::open_remote
};

class Gallery {
 public:
  /// Begins to read in the looking thread.
  explicit Gallery(GalleryOptions options);
  ~Gallery();
  Gallery(const Gallery&) = delete;
  Gallery& operator=(const Gallery&) = delete;

  /// What /api/gallery answers, without the notes.
  json::Value state() const;

  /// What is shown of an archive; null where nothing has been read (yet), or there is none.
  std::shared_ptr<const Snapshot> snapshot(std::size_t archive) const;
  /// Likewise, but no outline: while there is only that it waits, for 2 s at most. Null also where
  /// it has waited in vain.
  std::shared_ptr<const Snapshot> whole_snapshot(std::size_t archive) const;
  /// Why nothing more can be read of an archive that is damaged or gone, as sentences; else empty.
  std::string why_unreadable(std::size_t archive) const;
  std::size_t archives() const;
  /// Its file, for people; empty where there is none.
  std::string path_of(std::size_t archive) const;

  /// Says what is known of a run that goes on elsewhere: its archive is live, with such words.
  void set_live(const std::string& path, bool is_live, const std::string& words);

 private:
  struct Shown {
    std::string path{};
    std::string name{};
    ArchiveState state = ArchiveState::reading;
    std::string words{};
    std::uint64_t read = 0;  ///< animations, while it is read
    std::uint64_t of = 0;
    bool is_live = false;
    std::string live_words{};
    std::shared_ptr<const Snapshot> snapshot{};
    /// The last file that was tried; it is not tried again unless it changes.
    std::optional<browse::FileState> tried{};
    /// Of an outline: since when it is shown, and whether motions have been asked for.
    std::chrono::steady_clock::time_point outlined_at{};
    bool is_wanted = false;
    bool has_outline() const { return snapshot && snapshot->is_outline(); }
    /// Its motions can be had: the file is there, and nothing was wrong with it.
    bool may_become_whole() const { return has_outline() && state == ArchiveState::ready; }
  };
  void look_forever();
  void look_through_folders();
  void look_at(std::size_t archive);
  /// What is to be read of an archive, and beside what.
  struct Reading {
    std::string path{};
    browse::FileState file{};
    std::shared_ptr<const Snapshot> before{};
    /// What is shown of this file, whose generation the whole has.
    std::shared_ptr<const Snapshot> outline{};
  };
  /// Shows what was kept of the file, if something was.
  bool show_outline(std::size_t archive, const Reading& reading);
  /// Throws what Snapshot throws.
  std::shared_ptr<const Snapshot> read(std::size_t archive, const Reading& reading,
                                       std::uint64_t beginning_max);
  std::uint64_t new_generation();
  /// Shows what was read; null: why it can't be.
  void show(std::size_t archive, std::shared_ptr<const Snapshot> now, const std::string& fault);
  void tell();

  GalleryOptions options_;
  mutable std::mutex mutex_;  ///< of all below
  std::vector<std::unique_ptr<Shown>> shown_;
  std::vector<ListedFiles::LeftOut> left_out_;
  /// From milliseconds since 1970 on: a page that is open while a gallery is started again must not
  /// take another reading for the one that it has.
  std::uint64_t generation_;
  bool is_over_ = false;
  mutable std::condition_variable changed_;  ///< the end, what is shown, and what is wanted
  std::thread looking_;
};

}  // namespace sleight::gallery
