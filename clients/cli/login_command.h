// `sleight login` and `sleight logout`: services of other machines.
#pragma once

#include <string>

namespace sleight::cli {

struct LoginOptions {
  std::string address{};
  std::string token_file{};   ///< empty: standard input
  std::string fingerprint{};  ///< of a certificate of the service's own making
  std::string ca_file{};      ///< PEM, of the authority that vouches for it
  bool json = false;
};

/// Checks the token with the service and keeps it. The token is never an argument, where others
/// could see it. Throws base::Error: usage, not_allowed (another fingerprint, a wrong token),
/// no_server.
int login(const LoginOptions& options);

int logout(const std::string& address, bool json);

}  // namespace sleight::cli
