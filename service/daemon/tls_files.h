// The files of a TLS service's certificate and key. Thread safety: one thread.
#pragma once

#include <string>

#include "common/access/certificates.h"

namespace sleight::daemon {

/// Reads certificate and key from the two paths. Without paths, reads `certificate.pem` and
/// `key.pem` in the state folder's `tls`. If these files are missing, creates them; only the owner
/// can read the key. Throws base::Error if a file can't be read, if others can read the key, or if
/// the key doesn't match the certificate. The error names the file.
access::Keypair keypair_of(const std::string& state, const std::string& certificate_path,
                           const std::string& key_path);

}  // namespace sleight::daemon
