// What a caller may do by its token, and the audit log of what was done: a Handler before the one
// that does it.
//
// A session of a Unix socket may do all that its user may. One by a token may do what the token's
// scopes allow, and makes, shows and revokes no tokens.
//
// Thread safety: all on the loop's thread.
#pragma once

#include <string>
#include <vector>

#include "common/rpc/handler.h"
#include "service/daemon/audit_log.h"

namespace sleight::daemon {

class GuardedCalls final : public rpc::Handler {
 public:
  /// Both must outlive it; `audit` also the replies that it passes on, which may be dropped when it
  /// is gone.
  GuardedCalls(rpc::Handler& inner, AuditLog& audit) : inner_(inner), audit_(audit) {}

  void submit(const rpc::Caller& caller, rpc::Submission submission,
              rpc::Reply<rpc::Submitted> reply) override;
  void list(const rpc::Caller& caller, rpc::ListAsk ask, rpc::Reply<rpc::JobPage> reply) override;
  void status(const rpc::Caller& caller, rpc::JobId job, rpc::Reply<rpc::JobView> reply) override;
  base::Result<rpc::Batch, rpc::Refusal> events_after(const rpc::Caller& caller,
                                                      const rpc::WatchPoint& point,
                                                      std::size_t events_max) override;
  void logs(const rpc::Caller& caller, rpc::LogAsk ask, rpc::Reply<rpc::LogPiece> reply) override;
  void change(const rpc::Caller& caller, rpc::ChangeAsk ask,
              rpc::Reply<std::vector<rpc::Touched>> reply) override;
  void fetch(const rpc::Caller& caller, rpc::FetchAsk ask, rpc::Reply<rpc::Fetched> reply) override;
  void info(const rpc::Caller& caller, rpc::Reply<rpc::ServerView> reply) override;
  void drain(const rpc::Caller& caller, rpc::Reply<rpc::Nothing> reply) override;
  void stop(const rpc::Caller& caller, rpc::Reply<rpc::Nothing> reply) override;
  void create_token(const rpc::Caller& caller, rpc::TokenAsk ask,
                    rpc::Reply<rpc::TokenView> reply) override;
  void list_tokens(const rpc::Caller& caller,
                   rpc::Reply<std::vector<rpc::TokenView>> reply) override;
  void revoke_token(const rpc::Caller& caller, std::string id,
                    rpc::Reply<rpc::TokenView> reply) override;

 private:
  template <class T>
  rpc::Reply<T> audited(const rpc::Caller& caller, AuditLine line, rpc::Reply<T> reply);
  template <class T, class Call>
  void pass(const rpc::Caller& caller, rpc::Scope scope, AuditLine line, rpc::Reply<T> reply,
            const Call& call);
  template <class T, class Call>
  void pass_quietly(const rpc::Caller& caller, rpc::Reply<T> reply, const Call& call);
  template <class T, class Call>
  void pass_here(const rpc::Caller& caller, AuditLine line, rpc::Reply<T> reply, const Call& call);

  rpc::Handler& inner_;
  AuditLog& audit_;
};

/// Lets in whom `inner` does, and notes each attempt.
class AuditedAuthority final : public rpc::Authority {
 public:
  AuditedAuthority(rpc::Authority& inner, AuditLog& audit) : inner_(inner), audit_(audit) {}
  base::Result<rpc::Caller, rpc::Refusal> login(const std::string& token,
                                                const std::string& address) override;
  bool lets_go_on(const rpc::Caller& caller) override { return inner_.lets_go_on(caller); }

 private:
  rpc::Authority& inner_;
  AuditLog& audit_;
};

}  // namespace sleight::daemon
