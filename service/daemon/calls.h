// Answers the service's clients: implements common/rpc's Handler with a JobRunner.
//
// A caller sees and changes only its own jobs; the daemon's user and root see all jobs. Another
// user's job is reported as not found.
//
// Thread safety: only the loop's thread makes calls.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/rpc/handler.h"
#include "service/daemon/fetching.h"
#include "service/daemon/job_runner.h"
#include "service/daemon/logs.h"
#include "service/daemon/requests.h"
#include "service/daemon/tokens.h"

namespace sleight::daemon {

/// Facts about the server that clients see, and defaults for jobs.
struct ServerFacts {
  std::string version{};
  std::string results_version{};
  std::uint64_t cache_mb = 256;  ///< of each of a job's processes
  std::string keeping_rule{};
  std::vector<rpc::NamedLimit> limits{};
  RequestLimits request_limits{};
  std::uint32_t job_cores = 0;  ///< default for jobs without a wish; 0: whatever is free
  /// Throws base::Error if the backend doesn't support the options. Empty: it supports none.
  std::function<void(const std::map<std::string, std::string>&)> check_options{};
  std::string backend = "local";
  // The TCP address, if the server listens on TCP.
  std::string address{};
  std::string fingerprint{};
};

class Calls final : public rpc::Handler {
 public:
  Calls(rpc::Loop& loop, JobRunner& runner, Tokens& tokens, ServerFacts facts, ReadRequest read,
        std::function<void()> stop);

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

  /// Sets the server's TCP address. Clients can request it.
  void listens_at(std::string address, std::string fingerprint);

 private:
  bool is_operator(const rpc::Caller& caller) const;
  bool sees(const rpc::Caller& caller, const Posted& posted) const;
  /// Returns the job as the board has it. If the caller can't see the job, returns a refusal.
  base::Result<const Posted*, rpc::Refusal> look_up(const rpc::Caller& caller,
                                                    rpc::JobId job) const;
  base::Result<std::vector<jobs::JobId>, rpc::Refusal> jobs_of(const rpc::Caller& caller,
                                                               const rpc::Target& target) const;
  rpc::JobView view(const Posted& posted, bool with_progress);
  void add_end(rpc::JobView& view, const Posted& posted) const;
  base::Result<std::optional<StoredRequest>, rpc::Refusal> longer_request(
      jobs::JobId job, const rpc::Extension& extension) const;
  rpc::Refusal stalled() const;
  std::optional<rpc::Refusal> beyond_token(const rpc::Caller& caller, std::size_t more) const;
  std::optional<rpc::Refusal> may_not_revive(const rpc::Caller& caller,
                                             const std::vector<jobs::JobId>& jobs) const;
  static std::optional<rpc::Refusal> fit_to_token(const rpc::Caller& caller, rpc::JobAsk& ask);

  rpc::Loop& loop_;
  JobRunner& runner_;
  Tokens& tokens_;
  ServerFacts facts_;
  ReadRequest read_;
  std::function<void()> stop_;
  base::SteadyClock clock_;
  double begin_s_;
  std::map<std::string, std::size_t> being_submitted_{};  ///< jobs, by token
  Fetching fetching_;
  Logs logs_;
};

}  // namespace sleight::daemon
