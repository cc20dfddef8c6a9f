// Implements the calls that manage tokens, and the limits of tokens (calls.h).
#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.h"
#include "common/logging/log.h"
#include "service/daemon/calls.h"

namespace sleight::daemon {

/// `more`: number of unfinished jobs that a call adds. If the token's limit would be exceeded,
/// refuses the call. The user's limits also apply.
std::optional<rpc::Refusal> Calls::beyond_token(const rpc::Caller& caller, std::size_t more) const {
  if (caller.token_jobs_max == 0) return std::nullopt;
  const auto being = being_submitted_.find(caller.token_id);
  std::size_t count = being == being_submitted_.end() ? 0 : being->second;
  for (const auto& [id, posted] : runner_.board().all()) {
    if (posted.asked.token_id == caller.token_id && !jobs::is_over(posted.job.state)) ++count;
  }
  if (count + more <= caller.token_jobs_max) return std::nullopt;
  return rpc::Refusal{
      .kind = rpc::RefusalKind::limit,
      .sentence = fmt::format("This token allows at most {} unfinished jobs; the current number is "
                              "{}, and {} more were requested.",
                              caller.token_jobs_max, count, more),
      .what_to_do = "Wait until some jobs end, or use a token with a higher limit."};
}

/// A token with limits can't resume or extend other tokens' jobs, and no more jobs than its limit
/// allows. The token's own jobs already respect its limit of cores.
std::optional<rpc::Refusal> Calls::may_not_revive(const rpc::Caller& caller,
                                                  const std::vector<jobs::JobId>& jobs) const {
  if (caller.token_jobs_max == 0 && caller.token_cores_max == 0) return std::nullopt;
  std::size_t revived = 0;
  for (const jobs::JobId job : jobs) {
    const Posted& posted = *runner_.board().find(job);
    if (posted.asked.token_id != caller.token_id) {
      return rpc::Refusal{
          .kind = rpc::RefusalKind::limit,
          .sentence = fmt::format("This token has limits, and job {} was not submitted with it.",
                                  job.value),
          .what_to_do = "Use a token that was created without --jobs and --cores."};
    }
    if (jobs::is_over(posted.job.state)) ++revived;
  }
  return revived == 0 ? std::nullopt : beyond_token(caller, revived);
}

/// Applies the token's maximum of cores to a job. Refuses a job that requests more. If the job
/// requests no number of cores, sets the number to the maximum.
std::optional<rpc::Refusal> Calls::fit_to_token(const rpc::Caller& caller, rpc::JobAsk& ask) {
  const std::uint32_t cores_max = caller.token_cores_max;
  if (cores_max == 0) return std::nullopt;
  if (std::max(ask.cores.value_or(0), ask.ranks) <= cores_max) {
    if (!ask.cores && ask.ranks == 0) ask.cores = cores_max;
    return std::nullopt;
  }
  return rpc::Refusal{.kind = rpc::RefusalKind::limit,
                      .sentence = fmt::format("This token allows at most {} core{} per job.",
                                              cores_max, cores_max == 1 ? "" : "s"),
                      .what_to_do = "Request fewer cores or ranks."};
}

void Calls::create_token(const rpc::Caller& caller, rpc::TokenAsk ask,
                         rpc::Reply<rpc::TokenView> reply) {
  if (ask.for_user && *ask.for_user != caller.user && !is_operator(caller)) {
    reply.refuse(
        {.kind = rpc::RefusalKind::not_allowed,
         .sentence = "Only the user who runs the service can create tokens for other users."});
    return;
  }
  try {
    reply.give(tokens_.create(caller.user, ask));
  } catch (const base::Error& failure) {
    logging::warn(failure.what());
    reply.refuse(stalled());
  }
}

void Calls::list_tokens(const rpc::Caller& caller, rpc::Reply<std::vector<rpc::TokenView>> reply) {
  reply.answer(tokens_.of(is_operator(caller) ? std::nullopt : std::optional(caller.user)));
}

void Calls::revoke_token(const rpc::Caller& caller, std::string id,
                         rpc::Reply<rpc::TokenView> reply) {
  try {
    reply.give(tokens_.revoke(is_operator(caller) ? std::nullopt : std::optional(caller.user), id));
  } catch (const base::Error& failure) {
    logging::warn(failure.what());
    reply.refuse({.kind = rpc::RefusalKind::environment,
                  .sentence = fmt::format(
                      "Token {} is revoked, but the change can't be saved because the disk is full "
                      "or failing. The token would be valid again after a restart.",
                      id),
                  .what_to_do = "Free some disk space, then revoke the token again."});
  }
}

}  // namespace sleight::daemon
