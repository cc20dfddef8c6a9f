// Access tokens of peers over TCP, stored as `tokens.json` in the state folder.
//
// Only a hash of a token's secret is stored. A token belongs to a user. If a session logs in with
// the token, it acts as that user within the token's scopes.
//
// Invariants
//   1. create() and revoke() answer when their change is durable. The time of a token's last use is
//      written periodically. If the daemon is killed, the last minute of these times is lost.
//   2. login() doesn't reveal whether a token is unknown, wrong, expired or revoked.
//   3. If a token was revoked or found expired, it is never valid again, whatever the clock shows
//      later. The token stays in lists for some time. Expiry is checked at each use and once per
//      minute.
//
// Thread safety: only the loop's thread makes calls.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/base/file_system.h"
#include "common/rpc/handler.h"

namespace sleight::daemon {

/// How long a token stays in lists after it was revoked or expired.
inline constexpr double k_over_token_listed_s = 30.0 * 86400;
/// Interval at which the times of last use are saved.
inline constexpr double k_token_uses_saved_s = 60;

/// A token as the file stores it.
struct KeptToken {
  rpc::TokenView view{};
  std::string hash{};
};

class Tokens final : public rpc::Authority {
 public:
  /// `wall_s` returns seconds since 1970. Throws base::Error if the file can't be read or isn't
  /// valid. Such a file may have been changed and must authorize nobody.
  Tokens(base::FileSystem& files, std::string path, std::function<double()> wall_s,
         std::size_t of_user_max = rpc::k_tokens_max);

  /// Creates a token for `ask.for_user` if set, otherwise for `user`. If a call is repeated,
  /// returns the first answer.
  base::Result<rpc::TokenView, rpc::Refusal> create(std::uint32_t user, const rpc::TokenAsk& ask);
  /// Returns a user's tokens, newest first. None: of all users.
  std::vector<rpc::TokenView> of(std::optional<std::uint32_t> user);
  /// Revokes a token of this user; if `user` is empty, of any user. Other users' tokens count as
  /// not found.
  base::Result<rpc::TokenView, rpc::Refusal> revoke(std::optional<std::uint32_t> user,
                                                    const std::string& id);

  base::Result<rpc::Caller, rpc::Refusal> login(const std::string& token,
                                                const std::string& address) override;
  bool lets_go_on(const rpc::Caller& caller) override;

  /// Saves expiries and times of last use. Failures are logged.
  void save_uses();

 private:
  using Kept = KeptToken;
  bool is_valid(Kept& kept);
  void look_at_all();
  void read();
  void write();

  base::FileSystem& files_;
  std::string path_;
  std::function<double()> wall_s_;
  std::size_t of_user_max_;
  std::map<std::string, Kept> tokens_;  ///< by id
  bool is_saved_ = true;                ///< all but the times of last use
  bool has_new_uses_ = false;
};

}  // namespace sleight::daemon
