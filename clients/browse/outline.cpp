#include "clients/browse/outline.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "clients/browse/index_bytes.h"
#include "common/hash/sha256.h"

namespace sleight::browse {
namespace {

constexpr std::string_view k_outline_beginning = "sleight-browse-outline 1\n";

base::BytesView view_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

void put_behind_length(base::ByteWriter& writer, base::BytesView bytes) {
  writer.put(std::uint64_t{bytes.size()});
  writer.put(bytes);
}

std::optional<base::BytesView> behind_length(base::ByteReader& reader) {
  const auto size = reader.get<std::uint64_t>();
  return size ? reader.bytes(*size) : std::nullopt;
}

/// Returns nothing if the bytes contain an impossible value.
std::optional<AlikeGroup> group_of(base::ByteReader& reader, std::size_t entries) {
  AlikeGroup group;
  const auto representative = reader.get<std::uint64_t>();
  const auto members = reader.get<std::uint64_t>();
  if (!representative || *representative >= entries || !members || *members > entries)
    return std::nullopt;
  group.representative = *representative;
  for (std::uint64_t i = 0; i < *members; ++i) {
    const auto member = reader.get<std::uint64_t>();
    if (!member || *member >= entries) return std::nullopt;
    group.members.push_back(*member);
  }
  const auto mean_m = reader.get<double>();
  const auto greatest_m = reader.get<double>();
  if (!mean_m || !greatest_m) return std::nullopt;
  group.mean_m = *mean_m;
  group.greatest_m = *greatest_m;
  return group;
}

/// Decodes the bytes between the version and the checksum.
std::optional<Outline> outline_in(base::ByteReader& reader) {
  const auto index_bytes = behind_length(reader);
  auto index = index_bytes ? index_of(*index_bytes) : std::nullopt;
  const auto is_approximate = reader.get<std::uint8_t>();
  const auto groups = reader.get<std::uint64_t>();
  if (!index || !is_approximate || !groups || *groups > index->entries.size()) return std::nullopt;
  Outline outline{.index = *std::move(index), .groups = {.is_approximate = *is_approximate != 0}};
  for (std::uint64_t i = 0; i < *groups; ++i) {
    auto group = group_of(reader, outline.index.entries.size());
    if (!group) return std::nullopt;
    outline.groups.groups.push_back(*std::move(group));
  }
  return reader.at_end() ? std::optional(std::move(outline)) : std::nullopt;
}

}  // namespace

Outline outline_of(const Index& index, Groups groups) {
  Outline outline{.index = {.run_id = index.run_id,
                            .digest = index.digest,
                            .world = index.world,
                            .numbers = index.numbers},
                  .groups = std::move(groups)};
  outline.index.entries.reserve(index.entries.size());
  for (const Entry& entry : index.entries) {
    outline.index.entries.push_back({.name = entry.name,
                                     .row = entry.row,
                                     .lineage = entry.lineage,
                                     .in_proportion = entry.in_proportion,
                                     .end_s = entry.end_s,
                                     .events = entry.events,
                                     .numbers = entry.numbers,
                                     .tracks = std::vector<Track>(entry.tracks.size())});
  }
  return outline;
}

base::Bytes bytes_of(const Outline& outline, std::string_view version) {
  base::ByteWriter writer;
  writer.put(view_of(k_outline_beginning));
  put_behind_length(writer, view_of(version));
  put_behind_length(writer, bytes_of(outline.index));
  writer.put(std::uint8_t{outline.groups.is_approximate});
  writer.put(std::uint64_t{outline.groups.groups.size()});
  for (const AlikeGroup& group : outline.groups.groups) {
    writer.put(std::uint64_t{group.representative});
    writer.put(std::uint64_t{group.members.size()});
    for (const std::size_t member : group.members)
      writer.put(std::uint64_t{member});
    writer.put(group.mean_m);
    writer.put(group.greatest_m);
  }
  base::Bytes bytes = writer.take();
  const auto sum = hash::sha256_of(bytes);
  bytes.insert(bytes.end(), sum.begin(), sum.end());
  return bytes;
}

std::optional<Outline> outline_of_bytes(base::BytesView bytes, std::string_view version) {
  hash::Sha256::Value sum{};
  if (bytes.size() < sum.size()) return std::nullopt;
  const base::BytesView content = bytes.first(bytes.size() - sum.size());
  std::memcpy(sum.data(), bytes.data() + content.size(), sum.size());
  if (sum != hash::sha256_of(content)) return std::nullopt;
  base::ByteReader reader(content);
  const auto beginning = reader.bytes(k_outline_beginning.size());
  if (!beginning || !std::ranges::equal(*beginning, view_of(k_outline_beginning)))
    return std::nullopt;
  const auto by = behind_length(reader);
  if (!by || !std::ranges::equal(*by, view_of(version))) return std::nullopt;
  return outline_in(reader);
}

}  // namespace sleight::browse
