// An index as bytes, to be kept: what was read of an archive need not be read again.
//
// The scene is no part of it: the archive says it. The bytes are of this version of Sleight's
// browser and of one machine's kind; they end with their SHA-256, so that what was cut or changed
// is noticed. Thread safety: pure.
#pragma once

#include <cstddef>
#include <optional>

#include "clients/browse/index.h"
#include "common/base/bytes.h"

namespace sleight::browse {

base::Bytes bytes_of(const Index& index);

/// None of bytes that are not an index of this version, whole. By so many threads.
std::optional<Index> index_of(base::BytesView bytes, std::size_t threads = 1);

}  // namespace sleight::browse
