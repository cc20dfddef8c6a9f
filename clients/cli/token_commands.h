// `sleight token`: controls which people may call the service from other machines.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/rpc/service.h"

namespace sleight::cli {

struct TokenCreateOptions {
  std::string name{};
  std::vector<std::string> scopes{"read", "submit", "manage"};
  std::string expires = "90d";        ///< such as "90d", "12h" or "never"
  std::optional<std::string> user{};  ///< none: the caller
  std::uint32_t jobs_max = 0;
  std::uint32_t cores_max = 0;
  std::string output{};  ///< file for the token; empty: standard output
  bool json = false;
};

/// Creates a token, registers it with the service and prints it once. The service doesn't store the
/// token itself.
int create_token(const std::string& called, const TokenCreateOptions& options);

int list_tokens(const std::string& called, bool all, bool json);

struct TokenRevokeOptions {
  std::vector<std::string> ids{};
  bool json = false;
};
int revoke_tokens(const std::string& called, const TokenRevokeOptions& options);

/// Returns the seconds of "90d", "12h" or "never" (0). Throws base::Error(usage).
double validity_s_of(const std::string& text);

}  // namespace sleight::cli
