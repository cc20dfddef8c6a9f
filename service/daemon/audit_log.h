// The audit log records who did what, as lines of JSON in the state folder's `audit.log`:
//
//   {"time":"2026-11-27T14:05:09Z","call":"submit","user":1000,"from":"192.0.2.7:50312",
//    "token":"7k2m9q4x1c","of":"2 jobs","outcome":"done","made":"17 18"}.
//
//   `call` is login, submit, fetch, drain, stop, create_token, list_tokens, revoke_token, or a
//          change's kind such as cancel or set_priority.
//   `from` is a peer's address, or "process 4242" of this machine.
//   `token` is absent for calls over the Unix socket.
//   `outcome` is "done". If the call was refused, `outcome` is the refusal's kind and sentence.
//
// When `audit.log` is full, it is renamed to `audit.old.log`. A rate limit prevents users from
// pushing out older lines. For each kind of call, a user can cause k_audit_burst lines at once,
// then one line per ten seconds. Further lines are only counted. The count is logged periodically
// as {"call":"pin","user":1000,"more":812}.
//
// If logins have wrong tokens, their count is logged at most once per second. If the file can't be
// written, lines are lost but calls continue. The daemon's log reports the failure. Once writing
// works again, the number of lost lines is logged.
//
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "common/base/clock.h"
#include "common/base/descriptor.h"
#include "common/rpc/handler.h"

namespace sleight::daemon {

inline constexpr double k_audit_burst = 1000;
inline constexpr std::uint64_t k_audit_bytes_max = 16U << 20U;  ///< of each of the two files

class AuditLog {
 public:
  /// The first logged line creates the file.
  AuditLog(std::string folder, const base::Clock& clock,
           std::uint64_t bytes_max = k_audit_bytes_max);
  ~AuditLog();
  AuditLog(const AuditLog&) = delete;
  AuditLog& operator=(const AuditLog&) = delete;

  void note(const rpc::Caller& caller, const rpc::AuditLine& line);
  /// Logs a login with a wrong token.
  void note_stranger(const std::string& address);
  /// Logs how many wrong tokens and how many lines beyond the rate limit haven't been logged yet.
  void flush();

 private:
  /// How many lines a user can still cause with one kind of call.
  struct Share {
    double lines = k_audit_burst;
    double since_s = 0;      ///< time for which `lines` holds
    std::uint64_t more = 0;  ///< lines not logged and not yet counted in a line
    double told_s = 0;
  };
  using WhatByWhom = std::pair<std::uint32_t, std::string>;
  void tell_strangers(double now_s);
  void tell_more(double now_s);
  void open_file();
  void write(const std::string& line);

  std::string folder_;
  const base::Clock& clock_;
  std::uint64_t bytes_max_;
  base::Descriptor file_;
  std::uint64_t bytes_ = 0;
  std::uint64_t lost_ = 0;
  std::map<WhatByWhom, Share> shares_{};
  std::uint64_t strangers_ = 0;  ///< wrong tokens not yet logged
  std::string last_stranger_{};
  double strangers_told_s_ = -1e9;
};

/// Accepts the peers that `inner` accepts, and logs each login.
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
