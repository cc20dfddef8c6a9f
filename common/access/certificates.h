// Certificates of a service's TLS: one of its own making, and the fingerprint by which people know
// it.
//
// A certificate that vouches for itself, as the one that the service makes (k_self_name), is
// trusted by a client because it has that very certificate (`sleight login --fingerprint`),
// whatever the machine is called. Those of an authority are checked by host name as usual.
//
// Thread safety: any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

/// Of the first certificate, where it vouches for itself: the name that it is for. None: it is
/// somebody else's, or has no name.
std::optional<std::string> self_signed_name(std::string_view certificate);

/// Each certificate of a PEM text by itself.
std::vector<std::string> certificates_in(std::string_view text);

/// Whether the first one's time has come and is not over.
bool is_valid_now(std::string_view certificate);

/// Throws base::Error, which says what is wrong with them, unless the key is the certificate's.
void check_keypair(const Keypair& keypair);

/// The certificate that a server shows to anybody, as PEM; nothing is trusted or checked. Throws
/// base::Error where nobody answers so within some seconds.
std::string certificate_shown_at(const ServerAddress& address, double seconds_max);

/// Why a server's certificate is not trusted for a name by these certificates (PEM; empty: by those
/// that the system trusts), in OpenSSL's words; empty: it is. Throws as certificate_shown_at.
std::string fault_of_certificate_at(const ServerAddress& address, const std::string& name,
                                    const std::string& trusted, double seconds_max);

}  // namespace sleight::access
