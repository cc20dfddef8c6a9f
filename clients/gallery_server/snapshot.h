// An archive as it was read at one moment: everything that the page asks about it.
//
// A growing run's archive is replaced by a newer one now and then; each time it is read anew a new
// snapshot with a higher generation takes the old one's place. A snapshot keeps its file open, so
// what it answers is always of the same file.
//
// Of an archive that was browsed before, an *outline* can be there first
// (clients/browse/outline.h): a snapshot that has all but the index's motions, and the first
// groups. The whole snapshot that takes its place is of the same generation, since it says the
// same.
//
// Thread safety: values but for the file, which `read` guards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/browse/archives/index_cache.h"
#include "clients/browse/archives/kept_animations.h"
#include "clients/browse/groups.h"
#include "clients/browse/index.h"
#include "clients/browse/outline.h"
#include "clients/browse/reading.h"
#include "clients/gallery_server/shares.h"
#include "common/archive/model.h"
#include "common/archive/summary.h"

namespace sleight::gallery {

/// Draws that are looked through for shares of groups and for plots, at most.
inline constexpr std::uint64_t k_counted_draws_max = 50'000'000;

/// What an archive says besides its animations.
struct Facts {
  archive::Summary summary{};
  /// Draws are in the model's proportions: there are some, without weights and without a warning.
  bool in_proportion = false;
  std::optional<std::uint64_t> satisfied{};  ///< draws; none: too many to count
  SatisfiedDraws by_lineage{};               ///< where they are in proportion
  /// Log densities of blind throws, ascending; empty: the archive has none.
  std::vector<double> prior_log_prior{};
  std::string method{};  ///< "tempered"; empty: not known
};

/// Reads them. Draws are put to the animations of the whole index, of a beginning to none. Throws
/// base::Error where the archive is damaged.
Facts facts_of(const archive::Source& source, const browse::ReadIndex& read);

/// Opens an archive's file; throws base::Error.
using Opener = std::function<std::unique_ptr<archive::Source>(const std::string&)>;

class Snapshot {
 public:
  struct Options {
    std::uint64_t generation = 1;
    /// The file as it was before it was opened; none: it is looked at.
    std::optional<browse::FileState> file{};
    const Snapshot* earlier = nullptr;  ///< of the same place; what it has read is taken over
    /// So many of the first animations are enough, where all would have to be read; 0: all.
    std::uint64_t beginning_max = 0;
    /// What was kept of this very file, to be moved from: then nothing more is read. Where the
    /// archive is another all the same, it is read whole.
    browse::Outline* outline = nullptr;
    std::function<void(std::uint64_t, std::uint64_t)> progress{};  ///< animations, of how many
    Opener open{};  ///< none: archive::remote::open_remote
  };
  /// Opens and reads it. REQUIRES: `earlier` is no outline. Throws base::Error.
  Snapshot(const std::string& path, const Options& options);

  std::uint64_t generation() const { return generation_; }
  const browse::Index& index() const { return read_.index; }
  /// There are more animations in the archive than in the index.
  bool is_beginning() const { return read_.is_beginning; }
  /// Its index has no motions: neither queries nor resemblance can be asked of it.
  bool is_outline() const { return first_groups_.has_value(); }
  const Facts& facts() const { return facts_; }
  /// Of each entry, the satisfied draws that are put to it; empty where draws aren't in proportion.
  std::vector<double> satisfied_draws() const;
  /// Along the index.
  std::optional<std::size_t> entry_of(std::string_view name) const;

  /// All entries, to be compared and grouped; made at the first call. REQUIRES: no outline.
  const browse::AlikeSet& alike() const;
  /// Of all entries those that a page asks for first (browse::k_first_groups); an outline has them.
  browse::Groups first_groups() const;
  /// Keeps its outline for next time, unless it is too small to be worth it. REQUIRES: no outline,
  /// no beginning.
  void keep_outline(const std::string& path) const;

  /// Runs `work` with the archive; one at a time. Throws what it throws.
  void read(const std::function<void(const archive::Source&)>& work) const;
  /// An entry's motion and looks. Throws base::Error where the archive is damaged.
  browse::KeptAnimation animation(std::size_t entry) const;

 private:
  std::uint64_t generation_;
  std::optional<browse::FileState> file_;  ///< as it was before it was opened
  std::unique_ptr<archive::Source> source_;
  mutable std::mutex mutex_;
  browse::ReadIndex read_;
  std::optional<browse::Groups> first_groups_;  ///< of an outline
  Facts facts_;
  std::map<std::string, std::size_t, std::less<>> by_name_;
  mutable std::once_flag made_alike_;
  mutable std::optional<browse::AlikeSet> alike_;
};

}  // namespace sleight::gallery
