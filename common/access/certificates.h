// TLS certificates of a service, and the fingerprints by which people verify self-signed ones.
//
// A service can make its own certificate (k_self_name). A client trusts a self-signed certificate
// if the client has stored exactly this certificate (`sleight login --fingerprint`). The client
// checks the host's name only in certificates that an authority signed.
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

/// A certificate and its key as PEM texts. The text of the certificate may continue with the
/// certificates of the signing authorities.
struct Keypair {
  std::string certificate{};
  std::string key{};
};

/// Returns a P-256 key pair, valid for ten years. Throws base::Error if OpenSSL fails.
Keypair make_self_signed();

/// Returns "SHA256:" and 64 hexadecimal digits for the first certificate of a PEM text. Throws
/// base::Error if the text has no certificate.
std::string fingerprint_of(std::string_view certificate);

/// Returns the first certificate's host name if it is self-signed. Returns nothing if another party
/// signed the certificate, or if the certificate has no name.
std::optional<std::string> self_signed_name(std::string_view certificate);

std::vector<std::string> certificates_in(std::string_view text);

/// Returns whether the current time is within the first certificate's validity.
bool is_valid_now(std::string_view certificate);

/// Throws base::Error with the reason unless the key belongs to the certificate.
void check_keypair(const Keypair& keypair);

/// Returns the certificate that a server presents, as PEM, without checking it. Throws base::Error
/// if there is no valid answer within `seconds_max`.
std::string certificate_shown_at(const ServerAddress& address, double seconds_max);

/// Returns OpenSSL's reason for not trusting a server's certificate for the host `name`. The result
/// is empty if OpenSSL trusts the certificate. `trusted`: PEM of the trusted authorities; empty:
/// the system's. Throws as certificate_shown_at.
std::string fault_of_certificate_at(const ServerAddress& address, const std::string& name,
                                    const std::string& trusted, double seconds_max);

}  // namespace sleight::access
