// What is known of an archive's animations without their motions: what they are called, their
// numbers, and groups of what looks alike. A page that has been here before begins with it, while
// the index, a hundred times as large, is read.
//
// Thread safety: values, pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "clients/browse/groups.h"
#include "clients/browse/index.h"
#include "common/base/bytes.h"

namespace sleight::browse {

/// The groups that a page asks for first (clients/gallery/src/state/page.ts).
inline constexpr std::size_t k_first_groups = 12;
inline constexpr Grouping k_first_grouping = Grouping::medoids;

struct Outline {
  Index index{};    ///< its entries have no pieces and contacts, as if no body ever entered
  Groups groups{};  ///< of all entries: k_first_groups by k_first_grouping
};

/// REQUIRES: groups of all entries.
Outline outline_of(const Index& index, Groups groups);

/// `version`: of the program that made it. As an index's bytes these are one machine's, have no
/// scene, and end with their SHA-256.
base::Bytes bytes_of(const Outline& outline, std::string_view version);

/// None of bytes that are no whole outline by this very version.
std::optional<Outline> outline_of_bytes(base::BytesView bytes, std::string_view version);

}  // namespace sleight::browse
