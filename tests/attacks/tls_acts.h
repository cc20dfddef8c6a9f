// Attacks on TLS itself: random bytes, handshakes that are changed, stopped or cut into odd
// records, and data after a handshake. Thread safety: as for acts.h.
#pragma once

#include "tests/attacks/acts.h"

namespace sleight::attack {

void tls_noise(const Scene& scene);
void tls_hellos(const Scene& scene);
void tls_records(const Scene& scene);
void tls_half_handshakes(const Scene& scene);
void tls_after_handshakes(const Scene& scene);

}  // namespace sleight::attack
