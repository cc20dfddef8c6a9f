// The secret of a port's cookies. The secret is stored between galleries, so that open pages
// reconnect when the server restarts.
#pragma once

#include <cstdint>
#include <string>

namespace sleight::gallery {

/// The secret in $XDG_STATE_HOME/sleight/gallery/PORT.secret (default ~/.local/state/...), readable
/// only by its owner; created if missing. Empty if the secret cannot be stored; then the server
/// creates a new secret, and open pages need a new link.
std::string kept_secret(std::uint16_t port);

}  // namespace sleight::gallery
