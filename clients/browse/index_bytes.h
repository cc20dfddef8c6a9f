// Encodes an index as bytes for the cache.
//
// The bytes don't contain the scene, which the archive stores. The encoding is specific to the
// browser's version and the machine type. The bytes end with their SHA-256, so truncated or changed
// bytes are detected. Thread safety: pure.
#pragma once

#include <cstddef>
#include <optional>

#include "clients/browse/index.h"
#include "common/base/bytes.h"

namespace sleight::browse {

base::Bytes bytes_of(const Index& index);

/// Decodes with this many threads. Returns nothing unless the bytes are a complete index of this
/// version.
std::optional<Index> index_of(base::BytesView bytes, std::size_t threads = 1);

}  // namespace sleight::browse
