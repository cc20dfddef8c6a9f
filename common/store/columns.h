// Arrays of numbers in a column: their bytes as they are.
#pragma once

#include <cstring>
#include <vector>

#include "common/base/bytes.h"

namespace sleight::store {

/// A length that does not fit shows in the row's checksum.
template <class T>
void assign_bytes(std::vector<T>& values, base::BytesView bytes) {
  values.resize(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
}

}  // namespace sleight::store
