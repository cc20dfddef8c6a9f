// The facts about an archive's animations that a viewer can show without motions: names, numbers,
// and groups that look alike. If an archive was browsed before, a page shows the cached outline
// while the index, a hundred times as large, is read. Thread safety: values, pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "clients/browse/groups.h"
#include "clients/browse/index.h"
#include "common/base/bytes.h"

namespace sleight::browse {

/// The groups that a page requests first (clients/gallery/src/state/page.ts).
inline constexpr std::size_t k_first_groups = 12;
inline constexpr Grouping k_first_grouping = Grouping::medoids;

struct Outline {
  Index index{};    ///< entries without pieces and contacts, as if no body ever entered
  Groups groups{};  ///< k_first_groups groups of all entries by k_first_grouping
};

/// REQUIRES: groups of all entries.
Outline outline_of(const Index& index, Groups groups);

/// `version`: the program's version. The bytes depend on the machine type, contain no scene, and
/// end with their SHA-256.
base::Bytes bytes_of(const Outline& outline, std::string_view version);

/// Returns nothing unless the bytes are a complete outline of this version.
std::optional<Outline> outline_of_bytes(base::BytesView bytes, std::string_view version);

}  // namespace sleight::browse
