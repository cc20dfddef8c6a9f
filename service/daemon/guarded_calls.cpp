#include "service/daemon/guarded_calls.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

namespace sleight::daemon {
namespace {

constexpr std::size_t k_named_max = 20;  // jobs in one line

std::string name_of(const rpc::Target& target) {
  return target.job ? fmt::format("{}", target.job->value)
                    : fmt::format("g{}", target.group ? target.group->value : 0);
}

rpc::Refusal beyond_scope(rpc::Scope scope) {
  return {.kind = rpc::RefusalKind::not_allowed,
          .sentence = fmt::format("This token does not let you {}.", rpc::name_of(scope)),
          .what_to_do = fmt::format("One with `--scope {}` does.", rpc::name_of(scope))};
}

/// What came of a call, for the log.
std::string made_of(const rpc::Submitted& submitted) {
  std::vector<std::uint64_t> jobs;
  for (std::size_t i = 0; i < std::min(submitted.jobs.size(), k_named_max); ++i)
    jobs.push_back(submitted.jobs[i].value);
  std::string text = fmt::format("{}", fmt::join(jobs, " "));
  if (submitted.jobs.size() > k_named_max) text += " ...";
  return text;
}

std::string made_of(const rpc::TokenView& token) {
  return fmt::format("token {} of user {}", token.id, token.user);
}

template <class T>
std::string made_of(const T&) {
  return {};
}

}  // namespace

template <class T>
rpc::Reply<T> GuardedCalls::audited(const rpc::Caller& caller, AuditLine line,
                                    rpc::Reply<T> reply) {
  auto owed = std::make_shared<rpc::Reply<T>>(std::move(reply));
  // Without `this`: an answer may come, and be noted, when the calls are gone.
  return rpc::Reply<T>([&audit = audit_, caller, line = std::move(line),
                        owed](base::Result<T, rpc::Refusal> answer) mutable {
    if (answer.ok()) {
      line.outcome = "done";
      line.made = made_of(answer.value());
    } else {
      line.outcome =
          fmt::format("{}: {}", rpc::name_of(answer.error().kind), answer.error().sentence);
    }
    audit.note(caller, line);
    owed->give(std::move(answer));
  });
}

template <class T, class Call>
void GuardedCalls::pass(const rpc::Caller& caller, rpc::Scope scope, AuditLine line,
                        rpc::Reply<T> reply, const Call& call) {
  rpc::Reply<T> noted = audited(caller, std::move(line), std::move(reply));
  if (caller.scopes.has(scope)) {
    call(std::move(noted));
  } else {
    noted.refuse(beyond_scope(scope));
  }
}

/// Of calls that change nothing and give away no files: asked often.
template <class T, class Call>
void GuardedCalls::pass_quietly(const rpc::Caller& caller, rpc::Reply<T> reply, const Call& call) {
  if (caller.scopes.has(rpc::Scope::read)) {
    call(std::move(reply));
  } else {
    reply.refuse(beyond_scope(rpc::Scope::read));
  }
}

/// Of tokens: over the Unix socket alone.
template <class T, class Call>
void GuardedCalls::pass_here(const rpc::Caller& caller, AuditLine line, rpc::Reply<T> reply,
                             const Call& call) {
  rpc::Reply<T> noted = audited(caller, std::move(line), std::move(reply));
  if (caller.token_id.empty()) {
    call(std::move(noted));
  } else {
    noted.refuse({.kind = rpc::RefusalKind::not_allowed,
                  .sentence = "Tokens are made, shown and revoked on the service's machine alone.",
                  .what_to_do = "There, `sleight token` does it."});
  }
}

void GuardedCalls::submit(const rpc::Caller& caller, rpc::Submission submission,
                          rpc::Reply<rpc::Submitted> reply) {
  const std::size_t jobs = submission.jobs.size();
  pass(caller, rpc::Scope::submit,
       {.call = "submit", .of = fmt::format("{} job{}", jobs, jobs == 1 ? "" : "s")},
       std::move(reply), [&](rpc::Reply<rpc::Submitted> noted) {
         inner_.submit(caller, std::move(submission), std::move(noted));
       });
}

void GuardedCalls::list(const rpc::Caller& caller, rpc::ListAsk ask,
                        rpc::Reply<rpc::JobPage> reply) {
  pass_quietly(caller, std::move(reply), [&](rpc::Reply<rpc::JobPage> passed) {
    inner_.list(caller, std::move(ask), std::move(passed));
  });
}

void GuardedCalls::status(const rpc::Caller& caller, rpc::JobId job,
                          rpc::Reply<rpc::JobView> reply) {
  pass_quietly(caller, std::move(reply), [&](rpc::Reply<rpc::JobView> passed) {
    inner_.status(caller, job, std::move(passed));
  });
}

base::Result<rpc::Batch, rpc::Refusal> GuardedCalls::events_after(const rpc::Caller& caller,
                                                                  const rpc::WatchPoint& point,
                                                                  std::size_t events_max) {
  if (!caller.scopes.has(rpc::Scope::read)) return beyond_scope(rpc::Scope::read);
  return inner_.events_after(caller, point, events_max);
}

void GuardedCalls::logs(const rpc::Caller& caller, rpc::LogAsk ask,
                        rpc::Reply<rpc::LogPiece> reply) {
  pass_quietly(caller, std::move(reply), [&](rpc::Reply<rpc::LogPiece> passed) {
    inner_.logs(caller, ask, std::move(passed));
  });
}

void GuardedCalls::change(const rpc::Caller& caller, rpc::ChangeAsk ask,
                          rpc::Reply<std::vector<rpc::Touched>> reply) {
  pass(caller, rpc::Scope::manage,
       {.call = std::string(rpc::name_of(ask.kind)), .of = name_of(ask.target)}, std::move(reply),
       [&](auto noted) { inner_.change(caller, ask, std::move(noted)); });
}

void GuardedCalls::fetch(const rpc::Caller& caller, rpc::FetchAsk ask,
                         rpc::Reply<rpc::Fetched> reply) {
  const std::string of = fmt::format("{}", ask.job.value);
  pass(caller, rpc::Scope::read, {.call = "fetch", .of = of}, std::move(reply),
       [&](auto noted) { inner_.fetch(caller, std::move(ask), std::move(noted)); });
}

void GuardedCalls::info(const rpc::Caller& caller, rpc::Reply<rpc::ServerView> reply) {
  pass_quietly(caller, std::move(reply),
               [&](auto passed) { inner_.info(caller, std::move(passed)); });
}

void GuardedCalls::drain(const rpc::Caller& caller, rpc::Reply<rpc::Nothing> reply) {
  pass(caller, rpc::Scope::operate, {.call = "drain"}, std::move(reply),
       [&](auto noted) { inner_.drain(caller, std::move(noted)); });
}

void GuardedCalls::stop(const rpc::Caller& caller, rpc::Reply<rpc::Nothing> reply) {
  pass(caller, rpc::Scope::operate, {.call = "stop"}, std::move(reply),
       [&](auto noted) { inner_.stop(caller, std::move(noted)); });
}

void GuardedCalls::create_token(const rpc::Caller& caller, rpc::TokenAsk ask,
                                rpc::Reply<rpc::TokenView> reply) {
  pass_here(caller, {.call = "create_token"}, std::move(reply),
            [&](auto noted) { inner_.create_token(caller, std::move(ask), std::move(noted)); });
}

void GuardedCalls::list_tokens(const rpc::Caller& caller,
                               rpc::Reply<std::vector<rpc::TokenView>> reply) {
  pass_here(caller, {.call = "list_tokens"}, std::move(reply),
            [&](auto noted) { inner_.list_tokens(caller, std::move(noted)); });
}

void GuardedCalls::revoke_token(const rpc::Caller& caller, std::string id,
                                rpc::Reply<rpc::TokenView> reply) {
  const std::string of = id;
  pass_here(caller, {.call = "revoke_token", .of = of}, std::move(reply),
            [&](auto noted) { inner_.revoke_token(caller, std::move(id), std::move(noted)); });
}

base::Result<rpc::Caller, rpc::Refusal> AuditedAuthority::login(const std::string& token,
                                                                const std::string& address) {
  auto caller = inner_.login(token, address);
  if (caller) {
    audit_.note(caller.value(), {.call = "login", .outcome = "done"});
  } else {
    audit_.note_stranger(address);
  }
  return caller;
}

}  // namespace sleight::daemon
