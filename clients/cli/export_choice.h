// Which animations of an archive are exported.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "clients/browse/archives/animation_ids.h"
#include "clients/browse/archives/index_cache.h"
#include "common/archive/model.h"

namespace sleight::cli {

/// Without `all`, at most so many are written that were not named one by one.
inline constexpr std::size_t k_export_max = 100;

/// Ids, or queries and representatives, or neither: then all.
struct ExportChoice {
  std::vector<std::string> ids{};     ///< animation_ids.h
  std::vector<std::string> select{};  ///< queries (browse/query.h) that must all hold
  /// Of these one for each of so many groups that look alike (browse/groups.h).
  std::optional<std::size_t> representatives{};
  bool all = false;  ///< all of them, however many
  /// The archive's file as it was before it was opened, for index_cache.h; none: it does without.
  std::optional<browse::FileState> file{};
};

/// In the archive's order, ids in theirs, representatives with those of large groups first; at
/// least one. Throws base::Error: usage where a query can't be understood (its place is marked),
/// no animation is meant, or more than k_export_max are and may not be (`is_bounded`).
std::vector<browse::AnimationId> chosen(const archive::Source& source, const ExportChoice& choice,
                                        bool is_bounded);

}  // namespace sleight::cli
