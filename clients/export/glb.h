// The container of glTF 2.0 binary files (.glb): a JSON text and one buffer of numbers.
//
// Source: Khronos Group, "glTF 2.0 Specification", sections 3.6 (binary data) and 4.4 (GLB).
//
// A writer collects columns of numbers. Each becomes an accessor with a buffer view of its own,
// aligned to four bytes; a column that is there already is used again, so that equal meshes and
// equal times are stored once. The bytes depend on the calls alone. (Of Debian's tinygltf, only the
// writing would be used: it brings image codecs, and orders objects and prints numbers by its own
// rules, on which equal bytes would then depend.)
//
// Thread safety: one thread at a time uses a writer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "clients/export/axes.h"
#include "common/base/result.h"
#include "common/json/value.h"

namespace sleight::gltf {

/// Writers and readers hold files whole, some of them several times.
inline constexpr std::uint64_t k_glb_bytes_max = std::uint64_t{512} << 20;

/// A whole file.
struct Glb {
  std::string bytes{};
};

class GlbWriter {
 public:
  /// The number of an accessor.
  using Accessor = std::size_t;

  /// Of vertices. With least and greatest values, which glTF wants of positions.
  Accessor add_positions(std::span<const Float3> places);
  Accessor add_normals(std::span<const Float3> normals);
  /// As 16 bits where all fit. REQUIRES: not empty.
  Accessor add_indices(std::span<const std::uint32_t> indices);

  /// Of animations' samplers. Times have bounds too. REQUIRES: not empty; times ascend.
  Accessor add_times(std::span<const float> times_s);
  Accessor add_values(std::span<const Float3> values);
  Accessor add_values(std::span<const Float4> values);

  /// The file: `document` with the accessors, buffer views and the buffer added; or why there is
  /// none. REQUIRES: all text in it is valid UTF-8.
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
  /// By a hash of the bytes.
  std::unordered_multimap<std::uint64_t, Accessor> known_;
};

}  // namespace sleight::gltf
