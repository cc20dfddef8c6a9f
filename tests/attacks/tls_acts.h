// Attacks on TLS itself: random bytes, data after a handshake, and handshakes that are changed,
// stopped or cut into odd records. Thread safety: as for acts.h.
#pragma once

#include "tests/attacks/acts.h"

namespace sleight::attack {

void tls_noise(const Scene& scene);
void tls_hellos(const Scene& scene);
void tls_records(const Scene& scene);
void tls_half_handshakes(const Scene& scene);
void tls_after_handshakes(const Scene& scene);

}  // namespace sleight::attack
