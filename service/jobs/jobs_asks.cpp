// People's requests: submitting jobs and changing them.
#include <fmt/format.h>

#include <utility>

#include "common/base/check.h"
#include "service/jobs/jobs.h"

namespace sleight::jobs {
namespace {

Refusal wrong_state(const Job& job, std::string_view why, std::string_view what_to_do) {
  return {.kind = RefusalKind::wrong_state,
          .sentence = fmt::format("Job {} {}.", job.id, why),
          .what_to_do = std::string(what_to_do)};
}

}  // namespace

void Jobs::take(const Submit& input) {
  const auto answer = [&](JobId job, bool is_new, std::optional<Refusal> refusal) {
    effects_.emplace_back(
        Answer{.token = input.token, .job = job, .is_new = is_new, .refusal = std::move(refusal)});
  };
  if (auto refusal = refusal_of(input)) return answer({}, false, std::move(refusal));
  if (const Job* job = known(input)) return answer(job->id, false, std::nullopt);

  const JobId id{next_id_++};
  Job& job = jobs_[id];
  job.id = id;
  job.user = input.user;
  job.client_key = input.client_key;
  job.content = input.content;
  job.name = input.name;
  job.group = input.group;
  job.priority = input.priority;
  job.wishes = input.wishes;
  job.queued_since_s = clock_s_;
  job.submitted_wall = wall_;
  job.changed_wall = wall_;
  if (!job.client_key.empty()) by_key_[{job.user, job.client_key}] = id;
  join_indices(job);
  note(job, State::queued, Reason::submitted, {});
  answer(id, true, std::nullopt);
}

/// Returns the job that an earlier submit with the same key created.
const Job* Jobs::known(const Submit& input) const {
  if (input.client_key.empty()) return nullptr;
  const auto found = by_key_.find({input.user, input.client_key});
  return found == by_key_.end() ? nullptr : &jobs_.at(found->second);
}

std::optional<Refusal> Jobs::over_job_limit(UserId user, std::uint64_t before_it) const {
  const Account* account = accounts_.find(user);
  const std::uint64_t limit = accounts_.limits(user).jobs;
  const std::uint64_t unfinished = (account == nullptr ? 0 : account->unfinished) + before_it;
  if (limit == 0 || unfinished < limit) return std::nullopt;
  return Refusal{.kind = RefusalKind::over_limit,
                 .sentence = fmt::format("You would have {} unfinished jobs. The limit is {}.",
                                         unfinished + 1, limit),
                 .what_to_do = "Wait until some jobs end, or cancel some."};
}

std::optional<Refusal> Jobs::refusal_of(const Submit& input, std::uint64_t before_it) const {
  if (const Job* job = known(input)) {
    if (job->content == input.content) return std::nullopt;
    return Refusal{.kind = RefusalKind::key_in_use,
                   .sentence = fmt::format(
                       "The key '{}' was already used for job {}, which has a different request.",
                       input.client_key, job->id),
                   .what_to_do = "Submit this request with another key."};
  }
  if (auto refusal = over_job_limit(input.user, before_it)) return refusal;
  if (accounts_.is_over_bytes(input.user, false))
    return Refusal{.kind = RefusalKind::over_limit,
                   .sentence = "Your jobs have reached their disk limit.",
                   .what_to_do = "Delete finished jobs with `sleight delete`."};
  const std::uint32_t processes = input.wishes.processes();
  const std::uint32_t cores_limit = accounts_.limits(input.user).cores;
  if (cores_limit > 0 && processes > cores_limit)
    return Refusal{.kind = RefusalKind::over_limit,
                   .sentence = fmt::format("{} ranks need more than your limit of {} cores.",
                                           processes, cores_limit),
                   .what_to_do = "Request fewer ranks; the result is the same."};
  if (!room_) return std::nullopt;
  if (processes > room_->cores)
    return Refusal{.kind = RefusalKind::too_large,
                   .sentence = fmt::format("{} ranks need more than this machine's {} cores.",
                                           processes, room_->cores),
                   .what_to_do = "Request fewer ranks; the result is the same."};
  if (input.wishes.memory_bytes > room_->memory_bytes / processes)
    return Refusal{
        .kind = RefusalKind::too_large,
        .sentence = fmt::format(
            "{} processes with {} MB each need more memory than the {} MB available to jobs.",
            processes, input.wishes.memory_bytes / 1'000'000, room_->memory_bytes / 1'000'000),
        .what_to_do = "Request less memory or fewer ranks; the result is the same."};
  return std::nullopt;
}

void Jobs::take(const Ask& input) {
  const auto found = jobs_.find(input.job);
  std::optional<Refusal> refusal;
  if (found == jobs_.end() || found->second.is_leaving) {
    refusal = {.kind = RefusalKind::not_found,
               .sentence = fmt::format("There is no job {}.", input.job),
               .what_to_do = "`sleight list` shows existing jobs."};
  } else if (found->second.user != input.user && !input.is_operator) {
    refusal = {.kind = RefusalKind::not_allowed,
               .sentence = fmt::format("Job {} belongs to another user.", input.job),
               .what_to_do = "Ask that user or the server's administrator to make the change."};
  } else {
    refusal = carry_out(found->second, input);
  }
  effects_.emplace_back(
      Answer{.token = input.token, .job = input.job, .refusal = std::move(refusal)});
}

std::optional<Refusal> Jobs::carry_out(Job& job, const Ask& input) {
  switch (input.kind) {
    case AskKind::cancel:
      return cancel(job);
    case AskKind::hold:
      return hold(job);
    case AskKind::resume:
      return resume(job);
    case AskKind::extend:
      return extend(job);
    case AskKind::remove:
      return remove(job);
    case AskKind::pin:
    case AskKind::unpin:
      set_pinned(job, input.kind == AskKind::pin);
      return std::nullopt;
    case AskKind::set_priority:
      set_priority(job, input.priority);
      return std::nullopt;
  }
  CHECK(false);
}

std::optional<Refusal> Jobs::cancel(Job& job) {
  if (job.state == State::cancelled) return std::nullopt;
  if (is_over(job.state))
    return wrong_state(job, fmt::format("has ended with state '{}'", name_of(job.state)),
                       "To delete the job, use `sleight delete`.");
  if (is_active(job.state)) {
    ask_to_stop(job, Reason::cancel_asked, "The job is being cancelled.");
  } else {
    enter(job, State::cancelled, Reason::cancel_asked, "Cancelled.");
  }
  return std::nullopt;
}

std::optional<Refusal> Jobs::hold(Job& job) {
  const std::string words = fmt::format("To continue the job, run `sleight resume {}`.", job.id);
  if (is_over(job.state))
    return wrong_state(job, fmt::format("has ended with state '{}'", name_of(job.state)),
                       "Only an unfinished job can be held.");
  if (job.state == State::yielding && job.reason == Reason::cancel_asked)
    return wrong_state(job, "is being cancelled",
                       "After the job is cancelled, `sleight resume` resumes it.");
  if (job.reason == Reason::hold_asked) return std::nullopt;
  if (is_active(job.state)) {
    ask_to_stop(job, Reason::hold_asked, words);
  } else {
    enter(job, State::held, Reason::hold_asked, words);
  }
  return std::nullopt;
}

std::optional<Refusal> Jobs::resume(Job& job) {
  if (job.state == State::done)
    return wrong_state(job, "is done", "To compute more, use `sleight extend`.");
  if (job.state == State::yielding && job.reason == Reason::cancel_asked)
    return wrong_state(job, "is being cancelled",
                       "Wait until the job is cancelled, then resume it.");
  if (job.state == State::yielding && job.reason == Reason::hold_asked) {
    enter(job, State::yielding, Reason::resumed,
          "The job first stops and then resumes at its next turn.");
  } else if (is_over(job.state)) {
    if (auto refusal = over_job_limit(job.user)) return refusal;
    begin_anew(job, Reason::resumed, "The job resumes from its stored results.");
  } else if (job.state == State::held) {
    begin_anew(job, Reason::resumed, {});
  }
  return std::nullopt;
}

std::optional<Refusal> Jobs::extend(Job& job) {
  if (job.state == State::yielding && job.reason == Reason::cancel_asked)
    return wrong_state(job, "is being cancelled",
                       "Wait until the job is cancelled, then extend it.");
  if (is_over(job.state)) {
    if (auto refusal = over_job_limit(job.user)) return refusal;
  }
  ++job.revision;
  if (is_over(job.state)) {
    begin_anew(job, Reason::extended, {});
  } else {
    note(job, job.state, Reason::extended, "The request was extended.");
  }
  return std::nullopt;
}

std::optional<Refusal> Jobs::remove(Job& job) {
  if (!is_over(job.state))
    return wrong_state(job, fmt::format("is unfinished (state '{}')", name_of(job.state)),
                       fmt::format("Run `sleight cancel {}` first.", job.id));
  if (job.pinned)
    return wrong_state(job, "is pinned", fmt::format("Run `sleight pin {} --off` first.", job.id));
  let_go(job);
  return std::nullopt;
}

void Jobs::set_pinned(Job& job, bool pinned) {
  if (job.pinned == pinned) return;
  leave_indices(job);
  job.pinned = pinned;
  job.remove_at_s.reset();
  job.remove_wall = 0;
  join_indices(job);
  dirty_.insert(job.id);
}

void Jobs::set_priority(Job& job, std::int32_t priority) {
  if (job.priority == priority) return;
  leave_indices(job);
  job.priority = priority;
  join_indices(job);
  dirty_.insert(job.id);
}

/// At the user's request, queues a held or finished job again and forgets its past failures.
void Jobs::begin_anew(Job& job, Reason reason, std::string words) {
  leave_indices(job);
  job.next_start_s = 0;
  job.deaths = 0;
  job.back_offs = 0;
  job.fruitless = 0;
  job.bug_place.clear();
  job.over_since_s = 0;
  job.over_wall = 0;
  job.end = EndKind::none;
  job.remove_at_s.reset();
  job.remove_wall = 0;
  join_indices(job);
  enter(job, State::queued, reason, std::move(words));
}

}  // namespace sleight::jobs
