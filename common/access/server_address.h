// The TCP address of a service, such as "render.example.org:7423" or "[2001:db8::7]:7423".
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::access {

inline constexpr std::uint16_t k_port = 7423;  ///< the default

struct ServerAddress {
  std::string host{};  ///< name or numeric address, without brackets
  std::uint16_t port = k_port;
  bool operator==(const ServerAddress&) const = default;
};

/// Returns the address as text, always with its port.
std::string text_of(const ServerAddress& address);

/// Returns nothing if the text is not an address, for example because of an invalid character or a
/// port beyond 65535.
std::optional<ServerAddress> server_address_of(std::string_view text);

}  // namespace sleight::access
