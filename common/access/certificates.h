// Certificates of a service's TLS: one of its own making, and the fingerprint by which people know
// it.
//
// A certificate that the service makes itself names k_self_name and no host: a client trusts it
// because it has that very certificate (`sleight login --fingerprint`), whatever the machine is
// called. Those of an authority are checked by host name as usual.
//
// Thread safety: any thread.
#pragma once

#include <string>
#include <string_view>

#include "common/access/server_address.h"

namespace sleight::access {

inline constexpr const char* k_self_name = "sleight-service";

/// As PEM texts. A certificate may be followed by those that it hangs on.
struct Keypair {
  std::string certificate{};
  std::string key{};
};

/// P-256, valid for ten years. Throws base::Error where OpenSSL fails.
Keypair make_self_signed();

/// "SHA256:" and 64 hexadecimal digits, of the first certificate of a PEM text. Throws base::Error
/// where there is none.
std::string fingerprint_of(std::string_view certificate);

/// Whether it names k_self_name.
bool is_self_signed(std::string_view certificate);

/// Throws base::Error, which says what is wrong with them, unless the key is the certificate's.
void check_keypair(const Keypair& keypair);

/// The certificate that a server shows to anybody, as PEM; nothing is trusted or checked. Throws
/// base::Error where nobody answers so within some seconds.
std::string certificate_shown_at(const ServerAddress& address, double seconds_max);

}  // namespace sleight::access
