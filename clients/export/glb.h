// Writes the container of glTF 2.0 binary files (.glb): a JSON text and one buffer of numbers.
//
// Source: Khronos Group, "glTF 2.0 Specification", sections 3.6 (binary data) and 4.4 (GLB).
//
// A writer collects columns of numbers. Each column becomes an accessor with its own buffer view,
// aligned to four bytes. Equal columns, such as meshes and times, are stored once. The bytes depend
// only on the calls. (tinygltf isn't used: it brings image codecs, and the bytes would depend on
// its order of objects and its printing of numbers.) Thread safety: one thread at a time uses a
// writer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clients/export/axes.h"
#include "common/base/result.h"
#include "common/json/value.h"

namespace sleight::gltf {

/// Maximum size, because some writers and readers hold several copies of a file in memory.
inline constexpr std::uint64_t k_glb_bytes_max = std::uint64_t{512} << 20;

struct Glb {
  std::string bytes{};
};

class GlbWriter {
 public:
  using Accessor = std::size_t;

  /// Columns of vertices. Positions have minimum and maximum values, as glTF requires.
  Accessor add_positions(std::span<const Float3> places);
  Accessor add_normals(std::span<const Float3> normals);
  /// Indices are stored as 16 bits if all fit. REQUIRES: not empty.
  Accessor add_indices(std::span<const std::uint32_t> indices);

  /// Columns of animation samplers. Times also have minimum and maximum values. REQUIRES: not
  /// empty; times ascend.
  Accessor add_times(std::span<const float> times_s);
  Accessor add_values(std::span<const Float3> values);
  Accessor add_values(std::span<const Float4> values);

  /// Returns the file, with accessors, buffer views and the buffer added to `document`, or an error
  /// text. REQUIRES: all text in `document` is valid UTF-8.
  base::Result<Glb, std::string> finish(json::Value document) const;

 private:
  enum class Target : std::uint16_t { keys = 0, vertices = 34962, indices = 34963 };
  struct Column {
    std::size_t offset = 0;
    std::size_t bytes = 0;
    std::size_t count = 0;
    std::size_t width = 1;
    Target target = Target::keys;
    std::uint16_t component = 0;
    std::vector<float> low{};  ///< empty: no bounds
    std::vector<float> high{};
  };

  template <std::size_t width>
  Accessor add_vectors(std::span<const std::array<float, width>> vectors, Target target,
                       bool with_bounds);
  Accessor add(Column column, const std::string& bytes);

  std::string buffer_;
  std::vector<Column> columns_;
  /// Accessors by a hash of their bytes.
  std::unordered_multimap<std::uint64_t, Accessor> known_;
};

}  // namespace sleight::gltf
