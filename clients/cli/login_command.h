// `sleight login` stores tokens for services on other machines; `sleight logout` deletes them.
#pragma once

#include <string>

namespace sleight::cli {

struct LoginOptions {
  std::string address{};
  std::string token_file{};   ///< empty: standard input
  std::string fingerprint{};  ///< fingerprint of a self-signed certificate
  std::string ca_file{};      ///< PEM file of the certificate authority
  bool json = false;
};

/// Checks the token with the service and stores it. The token is never a command-line argument,
/// because other users could see it. Throws base::Error with exit code usage, no_server, or
/// not_allowed (another fingerprint, wrong token).
int login(const LoginOptions& options);

int logout(const std::string& address, bool json);

}  // namespace sleight::cli
