// The files of a TLS service's certificate and key. Thread safety: one thread.
#pragma once

#include <string>

#include "common/access/certificates.h"

namespace sleight::daemon {

/// Reads certificate and key from the two paths. Without paths, reads `certificate.pem` and
/// `key.pem` (readable only by the owner) in the state folder's `tls`, and creates them the first
/// time. Throws base::Error with the file's name if a file can't be read, if others can read the
/// key, or if the key doesn't match the certificate.
access::Keypair keypair_of(const std::string& state, const std::string& certificate_path,
                           const std::string& key_path);

}  // namespace sleight::daemon
