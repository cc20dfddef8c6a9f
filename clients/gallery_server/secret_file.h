// The secret of a port's cookies, kept from one gallery to the next, so that a page whose server is
// started again goes on by itself.
#pragma once

#include <cstdint>
#include <string>

namespace sleight::gallery {

/// Of $XDG_STATE_HOME/sleight/gallery/PORT.secret (else ~/.local/state/...), readable by its owner
/// alone; made where there is none. Empty where none can be kept: the server makes one of its own,
/// and pages need its link.
std::string kept_secret(std::uint16_t port);

}  // namespace sleight::gallery
