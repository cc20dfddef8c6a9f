// The tokens by which peers over TCP are let in, kept as `tokens.json` in the state folder.
//
// Of a token's secret only its hash is kept. A token is its user's: what a session by it does, that
// user does, as far as the token's scopes go.
//
// Invariants
//   1. What create and revoke have answered is durable. When a token was last used is written now
//      and then; a daemon that is killed forgets the last minute of it.
//   2. login tells nobody whether a token is unknown, wrong, expired or revoked.
//   3. A token that is revoked, or was seen to have expired, is never valid again, whatever the
//   clock
//      says later; it is listed for some time. One is seen when it is used, and each minute.
//
// Thread safety: all on the loop's thread.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/base/file_system.h"
#include "common/rpc/handler.h"

namespace sleight::daemon {

/// A token that is over is listed so much longer.
inline constexpr double k_over_token_listed_s = 30.0 * 86400;
/// What is known of uses is saved so often.
inline constexpr double k_token_uses_saved_s = 60;

/// As the file has it.
struct KeptToken {
  rpc::TokenView view{};
  std::string hash{};
};

class Tokens final : public rpc::Authority {
 public:
  /// `wall_s` is the time since 1970. Throws base::Error where the file can't be read, or is none
  /// of ours: nobody is let in by what may have been changed.
  Tokens(base::FileSystem& files, std::string path, std::function<double()> wall_s,
         std::size_t of_user_max = rpc::k_tokens_max);

  /// For its user, `ask.for_user` or `user`. The same token again answers what it did at first.
  base::Result<rpc::TokenView, rpc::Refusal> create(std::uint32_t user, const rpc::TokenAsk& ask);
  /// None: of all users. The newest first.
  std::vector<rpc::TokenView> of(std::optional<std::uint32_t> user);
  /// None as in `of`. Another's is answered like one that is not there.
  base::Result<rpc::TokenView, rpc::Refusal> revoke(std::optional<std::uint32_t> user,
                                                    const std::string& id);

  base::Result<rpc::Caller, rpc::Refusal> login(const std::string& token,
                                                const std::string& address) override;
  bool lets_go_on(const rpc::Caller& caller) override;

  /// Writes which have expired, and what is known of uses since the last save. Failures are logged.
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
  bool is_saved_ = true;                ///< all but uses
  bool has_new_uses_ = false;
};

}  // namespace sleight::daemon
