// Who did what, as lines of JSON in `audit.log` of the state folder: for whoever runs the service.
//
//   {"time":"2026-11-27T14:05:09Z","call":"submit","user":1000,"from":"192.0.2.7:50312",
//    "token":"7k2m9q4x1c","of":"2 jobs","outcome":"done","made":"17 18"}
//
//   call     login, submit, a change's kind (cancel, set_priority), fetch, drain, stop, or one of
//            create_token, list_tokens, revoke_token
//   from     a peer's address, or "process 4242" of this machine; token: none of a Unix socket's
//   outcome  "done", or the refusal's kind and sentence
//
// `audit.log`, and before it `audit.old.log`: when the first is full it takes the place of the
// second. Nobody can soon push out what happened before: of each call a user writes k_audit_burst
// lines at once, and then one in ten seconds; those beyond are told by their number, now and then:
//
//   {"time":"...","call":"pin","user":1000,"more":812}
//
// Strangers who show wrong tokens are written once a second at most, with their number. Where
// nothing can be written lines are lost, and nobody is stopped; the daemon's log says so, and how
// many were lost is said once it can be.
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
  /// Makes the file at the first line.
  AuditLog(std::string folder, const base::Clock& clock,
           std::uint64_t bytes_max = k_audit_bytes_max);
  ~AuditLog();
  AuditLog(const AuditLog&) = delete;
  AuditLog& operator=(const AuditLog&) = delete;

  void note(const rpc::Caller& caller, const rpc::AuditLine& line);
  /// Of somebody who showed a wrong token.
  void note_stranger(const std::string& address);
  /// Writes what strangers did meanwhile, and the numbers of what has no lines.
  void flush();

 private:
  /// How much a user may write of one call.
  struct Share {
    double lines = k_audit_burst;
    double since_s = 0;      ///< when it was so much
    std::uint64_t more = 0;  ///< that no line has told of yet
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
  std::uint64_t strangers_ = 0;  ///< that no line has told of yet
  std::string last_stranger_{};
  double strangers_told_s_ = -1e9;
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
