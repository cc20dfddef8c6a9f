// Peers that stay: some send a byte now and then, some nothing at all, over the socket and over
// TLS. What they hold must hinder nobody.
//
// Thread safety: run() is one thread's; tallies and trouble are shared.
#pragma once

#include <atomic>

#include "tests/attacks/acts.h"

namespace sleight::attack {

struct HeldTallies {
  Tally slow_on_socket{};
  Tally slow_over_tls{};
  Tally silent_on_socket{};
  Tally silent_over_tls{};
};

/// Until `is_over`. A slow peer is reached when the server has answered it, a silent one when it
/// has answered what the peer said before it fell silent.
void hold_peers(const Target& target, const std::atomic<bool>& is_over, HeldTallies& tallies);

}  // namespace sleight::attack
