// Stored and sent data as little-endian bytes: chain states, outcomes, counts.
//
// The reader checks every length, because bytes may come from a damaged or hostile file.
#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace sleight::base {

static_assert(std::endian::native == std::endian::little, "stored bytes are little-endian");

using Bytes = std::vector<std::byte>;
using BytesView = std::span<const std::byte>;

class ByteWriter {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) {
    const std::size_t size = bytes_.size();
    bytes_.resize(size + sizeof(T));
    std::memcpy(bytes_.data() + size, &value, sizeof(T));
  }
  void put(BytesView bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

/// Reads scalars and bytes in order; returns nothing after the end.
class ByteReader {
 public:
  explicit ByteReader(BytesView bytes) : rest_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T> std::optional<T> get() {
    if (rest_.size() < sizeof(T)) return std::nullopt;
    T value;
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_ = rest_.subspan(sizeof(T));
    return value;
  }
  /// Returns the next `size` bytes without copying.
  std::optional<BytesView> bytes(std::size_t size) {
    if (rest_.size() < size) return std::nullopt;
    const BytesView found = rest_.first(size);
    rest_ = rest_.subspan(size);
    return found;
  }
  bool at_end() const { return rest_.empty(); }

 private:
  BytesView rest_;
};

/// Returns a view of the bytes of an array of scalars.
template <class T>
requires std::is_arithmetic_v<T> BytesView bytes_of(std::span<const T> values) {
  return std::as_bytes(values);
}

}  // namespace sleight::base
