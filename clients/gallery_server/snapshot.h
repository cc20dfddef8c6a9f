// An archive as it was read at one moment, for all requests of the page.
//
// A growing run's archive is replaced by newer ones. Each new file becomes a new snapshot with a
// higher generation. A snapshot keeps its file open, so all its answers come from the same file.
//
// If an archive was browsed before, an *outline* (clients/browse/outline.h) can be shown first: a
// snapshot with the first groups and everything but the index's motions. The whole snapshot that
// replaces it has the same generation, because its answers are the same.
//
// Thread safety: immutable values, except for the file, which `read` guards.
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

/// Maximum number of draws that are read for shares of groups and for plots.
inline constexpr std::uint64_t k_counted_draws_max = 50'000'000;

/// Facts about an archive besides its animations.
struct Facts {
  archive::Summary summary{};
  /// Whether draws are in the model's proportions: true if there are draws, and no weights or
  /// warnings.
  bool in_proportion = false;
  std::optional<std::uint64_t> satisfied{};  ///< number of satisfied draws; none: too many to count
  SatisfiedDraws by_lineage{};               ///< empty unless draws are in proportion
  /// log_prior of blind throws, ascending; empty: the archive has none.
  std::vector<double> prior_log_prior{};
  std::string method{};  ///< such as "tempered"; empty: unknown
};

/// Reads the facts. Draws are assigned to animations only if the index is complete. Throws
/// base::Error if the archive is damaged.
Facts facts_of(const archive::Source& source, const browse::ReadIndex& read);

/// Opens an archive's file; throws base::Error.
using Opener = std::function<std::unique_ptr<archive::Source>(const std::string&)>;

class Snapshot {
 public:
  struct Options {
    std::uint64_t generation = 1;
    /// The file's state before the file was opened; none: the constructor determines the state.
    std::optional<browse::FileState> file{};
    const Snapshot* earlier = nullptr;  ///< earlier snapshot of the same path, to reuse its data
    /// Read only this many animations if all would have to be read; 0: read all.
    std::uint64_t beginning_max = 0;
    /// The stored outline of this file; its contents are moved. If `outline` is set, nothing more
    /// is read. If the file changed anyway, the archive is read as a whole.
    browse::Outline* outline = nullptr;
    std::function<void(std::uint64_t, std::uint64_t)> progress{};  ///< animations read, total
    Opener open{};  ///< none: archive::remote::open_remote
  };
  /// Opens and reads the archive. REQUIRES: `earlier` isn't an outline. Throws base::Error.
  Snapshot(const std::string& path, const Options& options);

  std::uint64_t generation() const { return generation_; }
  const browse::Index& index() const { return read_.index; }
  /// Whether the archive has more animations than the index.
  bool is_beginning() const { return read_.is_beginning; }
  /// Whether the index has no motions, so that queries and resemblance are unavailable.
  bool is_outline() const { return first_groups_.has_value(); }
  const Facts& facts() const { return facts_; }
  /// For each entry, the satisfied draws assigned to it; empty if draws aren't in proportion.
  std::vector<double> satisfied_draws() const;
  /// The index of the entry with this name.
  std::optional<std::size_t> entry_of(std::string_view name) const;

  /// Returns all entries prepared for comparing and grouping. The first call prepares them.
  /// REQUIRES: not an outline.
  const browse::AlikeSet& alike() const;
  /// The groups of all entries that pages request first (browse::k_first_groups); outlines contain
  /// them.
  browse::Groups first_groups() const;
  /// Stores the outline for next time, unless the archive is too small. REQUIRES: is_outline() and
  /// is_beginning() are false.
  void keep_outline(const std::string& path) const;

  /// Runs `work` with the archive; one call at a time. Throws what `work` throws.
  void read(const std::function<void(const archive::Source&)>& work) const;
  /// An entry's motion and looks. Throws base::Error if the archive is damaged.
  browse::KeptAnimation animation(std::size_t entry) const;

 private:
  std::uint64_t generation_;
  std::optional<browse::FileState> file_;  ///< state before it was opened
  std::unique_ptr<archive::Source> source_;
  mutable std::mutex mutex_;
  browse::ReadIndex read_;
  std::optional<browse::Groups> first_groups_;  ///< only in an outline
  Facts facts_;
  std::map<std::string, std::size_t, std::less<>> by_name_;
  mutable std::once_flag made_alike_;
  mutable std::optional<browse::AlikeSet> alike_;
};

}  // namespace sleight::gallery
