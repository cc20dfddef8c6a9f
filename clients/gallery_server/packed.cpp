#include "clients/gallery_server/packed.h"

#include <bit>
#include <cstddef>

namespace sleight::gallery {
namespace {

constexpr std::size_t k_alignment = 8;
static_assert(std::endian::native == std::endian::little, "columns are copied bytewise");

}  // namespace

void Packed::add_bytes(std::string_view name, const char* type, std::span<const std::byte> bytes,
                       std::size_t count) {
  columns_.push_back({{"name", name}, {"type", type}, {"offset", bytes_.size()}, {"count", count}});
  bytes_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  bytes_.resize((bytes_.size() + k_alignment - 1) / k_alignment * k_alignment, '\0');
}

void Packed::add(std::string_view name, std::span<const double> column) {
  add_bytes(name, "f64", std::as_bytes(column), column.size());
}
void Packed::add(std::string_view name, std::span<const float> column) {
  add_bytes(name, "f32", std::as_bytes(column), column.size());
}
void Packed::add(std::string_view name, std::span<const std::uint32_t> column) {
  add_bytes(name, "u32", std::as_bytes(column), column.size());
}
void Packed::add(std::string_view name, std::span<const std::int32_t> column) {
  add_bytes(name, "i32", std::as_bytes(column), column.size());
}
void Packed::add(std::string_view name, std::span<const std::uint8_t> column) {
  add_bytes(name, "u8", std::as_bytes(column), column.size());
}

std::string Packed::finish(const json::Value& head) const {
  const json::Value json = {{"head", head}, {"columns", columns_}};
  std::string text = json.dump();
  constexpr std::size_t k_length_bytes = sizeof(std::uint32_t);
  while ((text.size() + k_length_bytes) % k_alignment != 0)
    text += ' ';
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string whole(reinterpret_cast<const char*>(&length), k_length_bytes);
  whole.reserve(whole.size() + text.size() + bytes_.size());
  return whole.append(text).append(bytes_);
}

}  // namespace sleight::gallery
