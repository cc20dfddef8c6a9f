// `sleight groups`: what looks alike, each group with an animation that stands for it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/browse/archives/browsed.h"
#include "clients/browse/groups.h"

namespace sleight::cli {

struct GroupsOptions {
  std::vector<std::string> paths{};
  browse::QueryOptions asked{};  ///< only of these animations
  std::uint64_t groups = 12;
  std::string by = "medoids";  ///< or "hierarchy"
  std::string output{};        ///< a picture of the representatives; empty: none
  bool json = false;
};

/// Returns the exit code; throws base::Error.
int group_animations(const GroupsOptions& options);

/// The groups of picked animations. Throws base::Error(usage) where they are of scenes that can't
/// be compared, or more groups are asked for than can be told.
browse::Groups groups_of(const std::vector<browse::Picked>& picked, std::uint64_t groups,
                         browse::Grouping by);

}  // namespace sleight::cli
