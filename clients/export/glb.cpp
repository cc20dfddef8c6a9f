#include "clients/export/glb.h"

#include <algorithm>
#include <bit>
#include <utility>

#include <fmt/format.h>

#include "common/base/check.h"

namespace sleight::gltf {
namespace {

using Json = json::Value;

constexpr std::uint16_t k_unsigned_short = 5123;
constexpr std::uint16_t k_unsigned_int = 5125;
constexpr std::uint16_t k_float = 5126;
/// The greatest 16-bit index is reserved for primitive restart.
constexpr std::uint32_t k_short_index_max = 65534;

constexpr std::uint32_t k_magic = 0x46546C67;  // "glTF"
constexpr std::uint32_t k_version = 2;
constexpr std::uint32_t k_json_chunk = 0x4E4F534A;    // "JSON"
constexpr std::uint32_t k_binary_chunk = 0x004E4942;  // "BIN"
constexpr std::size_t k_head_bytes = 12;
constexpr std::size_t k_chunk_head_bytes = 8;
constexpr std::size_t k_alignment = 4;

void put(std::string& bytes, std::uint32_t value, int count = 4) {
  for (int i = 0; i < count; ++i)
    bytes += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
}

void pad(std::string& bytes, char with) {
  bytes.append((k_alignment - bytes.size() % k_alignment) % k_alignment, with);
}

/// FNV-1a, by Fowler, Noll and Vo.
std::uint64_t hash_of(const std::string& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes)
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  return hash;
}

}  // namespace

GlbWriter::Accessor GlbWriter::add(Column column, const std::string& bytes) {
  column.bytes = bytes.size();
  const std::uint64_t hash = hash_of(bytes);
  const auto [first, last] = known_.equal_range(hash);
  for (auto it = first; it != last; ++it) {
    const Column& old = columns_[it->second];
    if (old.target == column.target && old.width == column.width &&
        old.component == column.component && old.low.empty() == column.low.empty() &&
        buffer_.compare(old.offset, old.bytes, bytes) == 0)
      return it->second;
  }
  pad(buffer_, '\0');
  column.offset = buffer_.size();
  buffer_ += bytes;
  known_.emplace(hash, columns_.size());
  columns_.push_back(std::move(column));
  return columns_.size() - 1;
}

template <std::size_t width>
GlbWriter::Accessor GlbWriter::add_vectors(std::span<const std::array<float, width>> vectors,
                                           Target target, bool with_bounds) {
  CHECK(!vectors.empty());
  Column column{.count = vectors.size(), .width = width, .target = target, .component = k_float};
  if (with_bounds) {
    column.low.assign(vectors.front().begin(), vectors.front().end());
    column.high = column.low;
  }
  std::string bytes;
  bytes.reserve(4 * width * vectors.size());
  for (const auto& vector : vectors) {
    for (std::size_t i = 0; i < width; ++i) {
      put(bytes, std::bit_cast<std::uint32_t>(vector[i]));
      if (!with_bounds) continue;
      column.low[i] = std::min(column.low[i], vector[i]);
      column.high[i] = std::max(column.high[i], vector[i]);
    }
  }
  return add(std::move(column), bytes);
}

GlbWriter::Accessor GlbWriter::add_positions(std::span<const Float3> places) {
  return add_vectors(places, Target::vertices, true);
}

GlbWriter::Accessor GlbWriter::add_normals(std::span<const Float3> normals) {
  return add_vectors(normals, Target::vertices, false);
}

GlbWriter::Accessor GlbWriter::add_indices(std::span<const std::uint32_t> indices) {
  CHECK(!indices.empty());
  const bool is_short = *std::ranges::max_element(indices) <= k_short_index_max;
  std::string bytes;
  for (const std::uint32_t index : indices)
    put(bytes, index, is_short ? 2 : 4);
  return add({.count = indices.size(),
              .target = Target::indices,
              .component = is_short ? k_unsigned_short : k_unsigned_int},
             bytes);
}

GlbWriter::Accessor GlbWriter::add_times(std::span<const float> times_s) {
  std::vector<std::array<float, 1>> vectors;
  for (const float time_s : times_s)
    vectors.push_back({time_s});
  return add_vectors(std::span<const std::array<float, 1>>(vectors), Target::keys, true);
}

GlbWriter::Accessor GlbWriter::add_values(std::span<const Float3> values) {
  return add_vectors(values, Target::keys, false);
}

GlbWriter::Accessor GlbWriter::add_values(std::span<const Float4> values) {
  return add_vectors(values, Target::keys, false);
}

base::Result<Glb, std::string> GlbWriter::finish(Json document) const {
  static constexpr std::array<const char*, 5> k_types{"", "SCALAR", "", "VEC3", "VEC4"};
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const Column& column = columns_[i];
    Json accessor{{"bufferView", i},
                  {"componentType", column.component},
                  {"count", column.count},
                  {"type", k_types[column.width]}};
    if (!column.low.empty()) {
      accessor["min"] = std::vector<double>(column.low.begin(), column.low.end());
      accessor["max"] = std::vector<double>(column.high.begin(), column.high.end());
    }
    document["accessors"].push_back(std::move(accessor));
    Json view{{"buffer", 0}, {"byteOffset", column.offset}, {"byteLength", column.bytes}};
    if (column.target != Target::keys) view["target"] = static_cast<unsigned>(column.target);
    document["bufferViews"].push_back(std::move(view));
  }
  if (!buffer_.empty()) document["buffers"] = {{{"byteLength", buffer_.size()}}};

  // Write ASCII only, so that names can't affect a program that displays the text.
  std::string json = document.dump(-1, true);
  pad(json, ' ');
  std::string binary = buffer_;
  pad(binary, '\0');
  const std::uint64_t bytes = k_head_bytes + k_chunk_head_bytes + json.size() +
                              (binary.empty() ? 0 : k_chunk_head_bytes + binary.size());
  if (bytes > k_glb_bytes_max)
    return fmt::format("needs a file of {} bytes, above the maximum of {} bytes", bytes,
                       k_glb_bytes_max);
  Glb glb;
  std::string& file = glb.bytes;
  file.reserve(bytes);
  put(file, k_magic);
  put(file, k_version);
  put(file, static_cast<std::uint32_t>(bytes));
  put(file, static_cast<std::uint32_t>(json.size()));
  put(file, k_json_chunk);
  file += json;
  if (binary.empty()) return glb;
  put(file, static_cast<std::uint32_t>(binary.size()));
  put(file, k_binary_chunk);
  file += binary;
  return glb;
}

}  // namespace sleight::gltf
