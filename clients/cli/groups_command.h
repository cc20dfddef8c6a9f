// `sleight groups`: groups animations that look alike and chooses each group's representative.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/browse/archives/browsed.h"
#include "clients/browse/groups.h"

namespace sleight::cli {

struct GroupsOptions {
  std::vector<std::string> paths{};
  browse::QueryOptions asked{};  ///< which animations to group
  std::uint64_t groups = 12;
  std::string by = "medoids";  ///< or "hierarchy"
  std::string output{};        ///< file for a picture of the representatives; empty: none
  bool json = false;
};

int group_animations(const GroupsOptions& options);

/// Groups animations. Throws base::Error(usage) if scenes can't be compared, or if too many groups
/// are requested.
browse::Groups groups_of(const std::vector<browse::Picked>& picked, std::uint64_t groups,
                         browse::Grouping by);

}  // namespace sleight::cli
