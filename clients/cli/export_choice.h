// Selects animations to export.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "clients/browse/archives/animation_ids.h"
#include "clients/browse/archives/index_cache.h"
#include "common/archive/model.h"

namespace sleight::cli {

/// Maximum animations written if neither `all` nor ids are given.
inline constexpr std::size_t k_export_max = 100;

/// Ids, or queries with representatives. Default: all animations.
struct ExportChoice {
  std::vector<std::string> ids{};     ///< animation_ids.h
  std::vector<std::string> select{};  ///< queries (browse/query.h) that must all hold
  /// Maximum number of groups of similar animations (browse/groups.h). One animation per group is
  /// exported.
  std::optional<std::size_t> representatives{};
  bool all = false;  ///< no maximum
  /// State of the archive's file before it was opened. For index_cache.h. None: no cache.
  std::optional<browse::FileState> file{};
};

/// Returns at least one animation. Animations are in the order of the given ids, otherwise in the
/// archive's order. Representatives of larger groups come first. Throws base::Error(usage) if a
/// query is invalid (with its position), if nothing matches, or if `is_bounded` and more than
/// k_export_max animations match.
std::vector<browse::AnimationId> chosen(const archive::Source& source, const ExportChoice& choice,
                                        bool is_bounded);

}  // namespace sleight::cli
