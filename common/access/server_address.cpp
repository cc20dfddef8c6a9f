#include "common/access/server_address.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace sleight::access {
namespace {

constexpr std::size_t k_host_characters_max = 253;

bool is_of(std::string_view text, std::string_view more) {
  return std::ranges::all_of(text, [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           more.find(c) != std::string_view::npos;
  });
}

std::optional<std::uint16_t> port_of(std::string_view text) {
  std::uint16_t port = 0;
  const char* end = text.data() + text.size();
  const auto [rest, failure] = std::from_chars(text.data(), end, port);
  if (failure != std::errc() || rest != end || text.empty()) return std::nullopt;
  return port;
}

}  // namespace

std::string text_of(const ServerAddress& address) {
  const bool is_number_6 = address.host.find(':') != std::string::npos;
  return is_number_6 ? fmt::format("[{}]:{}", address.host, address.port)
                     : fmt::format("{}:{}", address.host, address.port);
}

std::optional<ServerAddress> server_address_of(std::string_view text) {
  ServerAddress address;
  std::string_view port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    address.host = text.substr(1, end - 1);
    if (!is_of(address.host, ":.")) return std::nullopt;
    port = text.substr(end + 1);
  } else {
    const std::size_t colon = std::min(text.find(':'), text.size());
    address.host = text.substr(0, colon);
    if (!is_of(address.host, ".-_") || address.host.starts_with('-')) return std::nullopt;
    port = text.substr(colon);
  }
  if (address.host.empty() || address.host.size() > k_host_characters_max) return std::nullopt;
  if (port.empty()) return address;
  const auto number = port.starts_with(':') ? port_of(port.substr(1)) : std::nullopt;
  if (!number) return std::nullopt;
  address.port = *number;
  return address;
}

}  // namespace sleight::access
