// Peers that stay connected, over the socket and over TLS. Slow peers send single bytes; silent
// peers send nothing. Held peers must not hinder others. Thread safety: run() belongs to one
// thread; the rest is shared.
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

/// Holds peers until `is_over`. A peer counts as reached once the server has answered it.
void hold_peers(const Target& target, const std::atomic<bool>& is_over, HeldTallies& tallies);

}  // namespace sleight::attack
