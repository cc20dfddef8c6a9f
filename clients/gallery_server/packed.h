// Writes columns of numbers as one answer for the page. Browsers use the columns as typed arrays
// without parsing.
//
//   `u32`: length of the text, little-endian.
//   `text`: JSON {"head": ..., "columns": [{"name", "type", "offset", "count"}, ...]},
//     padded with blanks so that `u32` and `text` together are a multiple of 8 bytes.
//   `columns`: each at its offset from the text's end, a multiple of 8; little-endian.
//
// Types are f64, f32, u32, i32 and u8. Thread safety: one thread at a time uses a writer.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/value.h"
#include "common/math/vector.h"

namespace sleight::gallery {

/// Appends a vector to a column with three numbers per row.
inline void append(std::vector<double>& column, const math::Vec3& v) {
  column.insert(column.end(), {v.x(), v.y(), v.z()});
}

class Packed {
 public:
  void add(std::string_view name, std::span<const double> column);
  void add(std::string_view name, std::span<const float> column);
  void add(std::string_view name, std::span<const std::uint32_t> column);
  void add(std::string_view name, std::span<const std::int32_t> column);
  void add(std::string_view name, std::span<const std::uint8_t> column);

  /// The whole answer. Invalid UTF-8 in `head` is replaced.
  std::string finish(const json::Value& head) const;

 private:
  void add_bytes(std::string_view name, const char* type, std::span<const std::byte> bytes,
                 std::size_t count);

  json::Value columns_ = json::Value::array();
  std::string bytes_;
};

}  // namespace sleight::gallery
