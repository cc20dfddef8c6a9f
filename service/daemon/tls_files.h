// The certificate and key of a service over TLS, as files.
//
// Thread safety: one thread.
#pragma once

#include <string>

#include "common/access/certificates.h"

namespace sleight::daemon {

/// Those of the two paths; without paths those in `tls` of the state folder, which are made the
/// first time: `certificate.pem`, and `key.pem` for its owner alone. Throws base::Error, with the
/// file's name: it can't be read, the key is readable by others, or is not the certificate's.
access::Keypair keypair_of(const std::string& state, const std::string& certificate_path,
                           const std::string& key_path);

}  // namespace sleight::daemon
