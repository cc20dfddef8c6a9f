// Where a service is reached over TCP: "render.example.org:7423", "192.0.2.7",
// "[2001:db8::7]:7423".
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::access {

inline constexpr std::uint16_t k_port = 7423;  ///< where none is given

struct ServerAddress {
  std::string host{};  ///< a name or a number, without brackets
  std::uint16_t port = k_port;
  bool operator==(const ServerAddress&) const = default;
};

/// As text, always with its port.
std::string text_of(const ServerAddress& address);

/// None where it is no address: an odd character, a port beyond 65535.
std::optional<ServerAddress> server_address_of(std::string_view text);

}  // namespace sleight::access
