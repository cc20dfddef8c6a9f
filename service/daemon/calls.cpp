#include "service/daemon/calls.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "common/base/error.h"
#include "common/logging/log.h"
#include "service/daemon/views.h"
#include "service/keeper/attempt_record.h"

namespace sleight::daemon {
namespace {

rpc::Refusal not_there(rpc::JobId job, bool was_there) {
  return {.kind = was_there ? rpc::RefusalKind::gone : rpc::RefusalKind::not_found,
          .sentence = was_there ? fmt::format("Job {} has been deleted.", job.value)
                                : fmt::format("There is no job {}.", job.value),
          .what_to_do = "`sleight list` shows existing jobs."};
}

/// Returns whether this call of `list` selects the job.
bool matches(const rpc::ListAsk& ask, const Posted& posted) {
  const jobs::Job& job = posted.job;
  if (ask.group && job.group.value != ask.group->value) return false;
  if (ask.user && job.user.value != *ask.user) return false;
  if (!ask.states.empty() &&
      std::find(ask.states.begin(), ask.states.end(), rpc_state(job.state)) == ask.states.end())
    return false;
  return ask.name_part.empty() || job.name.find(ask.name_part) != std::string::npos;
}

/// A cursor is the id of the last job on the previous page.
std::optional<std::uint64_t> id_of_cursor(const std::string& cursor) {
  std::uint64_t id = 0;
  const char* end = cursor.data() + cursor.size();
  const auto [rest, failure] = std::from_chars(cursor.data(), end, id);
  if (failure != std::errc() || rest != end) return std::nullopt;
  return id;
}

rpc::Touched touched_of(jobs::JobId job, const Board& board, const std::string& refused) {
  rpc::Touched touched{.job = rpc_id(job), .words = refused};
  const Posted* posted = board.find(job);
  if (posted == nullptr) return touched;
  touched.state = rpc_state(posted->job.state);
  if (touched.words.empty()) touched.words = reason_of(posted->job);
  return touched;
}

std::optional<rpc::Refusal> wrong_options(const ServerFacts& facts,
                                          const std::map<std::string, std::string>& options) {
  if (!facts.check_options) return std::nullopt;
  try {
    facts.check_options(options);
  } catch (const base::Error& failure) {
    return rpc::Refusal{.kind = rpc::RefusalKind::bad_request, .sentence = failure.what()};
  }
  return std::nullopt;
}

}  // namespace

Calls::Calls(rpc::Loop& loop, JobRunner& runner, Tokens& tokens, ServerFacts facts,
             ReadRequest read, std::function<void()> stop)
    : loop_(loop),
      runner_(runner),
      tokens_(tokens),
      facts_(std::move(facts)),
      read_(std::move(read)),
      stop_(std::move(stop)),
      begin_s_(clock_.now_s()),
      fetching_({.loop = loop,
                 .worker = runner.worker(),
                 .maker = runner.maker(),
                 .folders = runner.folders(),
                 .sleight = runner.options().programs.sleight}) {}

bool Calls::is_operator(const rpc::Caller& caller) const {
  // Require the scope: with a restricted token, even an operator doesn't see all jobs.
  return caller.scopes.has(rpc::Scope::operate) && (caller.user == 0 || caller.user == ::geteuid());
}

bool Calls::sees(const rpc::Caller& caller, const Posted& posted) const {
  return is_operator(caller) || posted.job.user.value == caller.user;
}

base::Result<const Posted*, rpc::Refusal> Calls::look_up(const rpc::Caller& caller,
                                                         rpc::JobId job) const {
  const Posted* posted = runner_.board().find(job_id(job));
  if (posted == nullptr) return not_there(job, runner_.board().was_there(job_id(job)));
  if (!sees(caller, *posted)) return not_there(job, false);
  return posted;
}

base::Result<std::vector<jobs::JobId>, rpc::Refusal> Calls::jobs_of(
    const rpc::Caller& caller, const rpc::Target& target) const {
  if (target.job) {
    const auto posted = look_up(caller, *target.job);
    if (!posted) return posted.error();
    return std::vector<jobs::JobId>{posted.value()->job.id};
  }
  std::vector<jobs::JobId> seen;
  for (const jobs::JobId job : runner_.board().group(jobs::GroupId{target.group->value})) {
    if (sees(caller, *runner_.board().find(job))) seen.push_back(job);
  }
  if (seen.empty()) {
    return rpc::Refusal{.kind = rpc::RefusalKind::not_found,
                        .sentence = fmt::format("There is no group g{}.", target.group->value),
                        .what_to_do = "`sleight list` shows each job's group."};
  }
  return seen;
}

rpc::Refusal Calls::stalled() const {
  return {.kind = rpc::RefusalKind::environment,
          .sentence = "The service can't save changes because its disk is full or failing.",
          .what_to_do =
              "Free some space on the disk of the service's state folder. Changes that were "
              "already accepted are not lost."};
}

void Calls::submit(const rpc::Caller& caller, rpc::Submission submission,
                   rpc::Reply<rpc::Submitted> reply) {
  if (!runner_.stalled().empty()) {
    reply.refuse(stalled());
    return;
  }
  if (auto refused = beyond_token(caller, submission.jobs.size())) {
    reply.refuse(*std::move(refused));
    return;
  }
  const bool is_group = submission.is_group || submission.jobs.size() > 1;
  std::vector<JobRunner::Submission> submissions;
  for (std::size_t i = 0; i < submission.jobs.size(); ++i) {
    rpc::JobAsk& ask = submission.jobs[i];
    if (auto refused = fit_to_token(caller, ask)) {
      reply.refuse(*std::move(refused));
      return;
    }
    auto request = checked_request(ask, read_, facts_.request_limits);
    if (!request) {
      reply.refuse(request.error());
      return;
    }
    StoredRequest stored = std::move(request).value();
    stored.token_id = caller.token_id;
    if (auto refused = wrong_options(facts_, stored.options)) {
      reply.refuse(*std::move(refused));
      return;
    }
    const std::uint64_t processes = std::max(1U, ask.ranks);
    const std::uint64_t cache_bytes =
        ask.memory_bytes > 0 ? ask.memory_bytes / processes : facts_.cache_mb << 20U;
    submissions.push_back(
        {.submit = {.token = 0,
                    .user = jobs::UserId{caller.user},
                    // Give each job of a group its own key. If the submission is repeated, the
                    // machine then recognises each job.
                    .client_key = submission.key.empty() ? std::string()
                                  : is_group             ? fmt::format("{}/{}", submission.key, i)
                                                         : submission.key,
                    .content = content_of(ask, stored.text),
                    .name = ask.name.empty() ? stored.world : ask.name,
                    .group = is_group ? runner_.next_group() : jobs::GroupId{},
                    .priority = ask.priority,
                    .wishes = {.cores = ask.cores.value_or(ask.ranks > 0 ? 0 : facts_.job_cores),
                               .ranks = ask.ranks,
                               .memory_bytes = cache_bytes + k_process_bytes}},
         .request = std::move(stored)});
  }
  auto owed = std::make_shared<rpc::Reply<rpc::Submitted>>(std::move(reply));
  // The board shows jobs only once they are durable.
  const std::size_t count = submissions.size();
  being_submitted_[caller.token_id] += count;
  const auto done = [this, token = caller.token_id, count] {
    const auto being = being_submitted_.find(token);
    if ((being->second -= count) == 0) being_submitted_.erase(being);
  };
  runner_.submit(std::move(submissions),
                 [this, owed, done](const std::vector<jobs::Answer>& answers) {
                   done();
                   rpc::Submitted submitted{.was_known = true};
                   for (const jobs::Answer& answer : answers) {
                     if (answer.refusal) {
                       owed->refuse(refusal_of(*answer.refusal));
                       return;
                     }
                     submitted.jobs.push_back(rpc_id(answer.job));
                     submitted.was_known = submitted.was_known && !answer.is_new;
                   }
                   const Posted* first = runner_.board().find(answers.front().job);
                   if (first != nullptr && first->job.group.value > 0)
                     submitted.group = rpc::GroupId{first->job.group.value};
                   owed->answer(std::move(submitted));
                 });
}

void Calls::list(const rpc::Caller& caller, rpc::ListAsk ask, rpc::Reply<rpc::JobPage> reply) {
  const std::optional<std::uint64_t> after = id_of_cursor(ask.cursor);
  if (!ask.cursor.empty() && !after) {
    reply.refuse({.kind = rpc::RefusalKind::bad_request,
                  .sentence = "The list cursor is invalid.",
                  .what_to_do = "Request the first page."});
    return;
  }
  rpc::JobPage page;
  const std::size_t count = std::clamp<std::size_t>(ask.count, 1, rpc::k_page_jobs_max);
  const auto take = [&](const auto& entry) {
    const Posted& posted = entry.second;
    if (posted.job.is_leaving || !sees(caller, posted) || !matches(ask, posted)) return;
    ++page.total;
    const std::uint64_t id = posted.job.id.value;
    if (after && (ask.oldest_first ? id <= *after : id >= *after)) return;
    if (page.jobs.size() < count) {
      page.jobs.push_back(view(posted, true));
    } else if (page.cursor.empty()) {
      page.cursor = std::to_string(page.jobs.back().id.value);
    }
  };
  const auto& all = runner_.board().all();
  if (ask.oldest_first) {
    std::for_each(all.begin(), all.end(), take);
  } else {
    std::for_each(all.rbegin(), all.rend(), take);
  }
  reply.answer(std::move(page));
}

/// `with_progress` adds an active run's progress. The run's log may have to be read for this.
rpc::JobView Calls::view(const Posted& posted, bool with_progress) {
  const events::Progress* progress = nullptr;
  if (with_progress && jobs::is_active(posted.job.state)) {
    const auto& newest = runner_.feeds().of(posted.job.id).progress();
    if (newest) progress = &*newest;
  }
  return view_of({.posted = posted, .machine = runner_.machine(), .progress = progress});
}

/// Adds a failed job's last output, and the command to repeat the failure.
void Calls::add_end(rpc::JobView& view, const Posted& posted) const {
  if (posted.job.state != jobs::State::failed) return;
  try {
    const auto record = keeper::read_record(runner_.folders().folder(posted.job.id));
    if (!record) return;
    std::string command = "cd " + runner_.folders().folder(posted.job.id) + " &&";
    for (const std::string& argument : record->command)
      command += " " + argument;
    view.repeat_command = std::move(command);
    if (record->end) view.last_log_lines = record->end->log_tail;
  } catch (const base::Error& failure) {
    logging::warn(failure.what());
  }
}

void Calls::status(const rpc::Caller& caller, rpc::JobId job, rpc::Reply<rpc::JobView> reply) {
  const auto posted = look_up(caller, job);
  if (!posted) {
    reply.refuse(posted.error());
    return;
  }
  rpc::JobView whole = view(*posted.value(), true);
  const std::uint64_t changes = posted.value()->changes;
  const std::uint64_t from = changes > rpc::k_history_max ? changes - rpc::k_history_max + 1 : 1;
  for (const auto& change : runner_.reader().changes(job_id(job), from, rpc::k_history_max))
    whole.history.push_back(change_of(change));
  add_end(whole, *posted.value());
  reply.answer(std::move(whole));
}

base::Result<rpc::Batch, rpc::Refusal> Calls::events_after(const rpc::Caller& caller,
                                                           const rpc::WatchPoint& point,
                                                           std::size_t events_max) {
  const auto found = look_up(caller, point.job);
  if (!found) return found.error();
  const Posted& posted = *found.value();
  const jobs::JobId job = posted.job.id;
  rpc::Batch batch;
  std::uint64_t changes = point.change;
  if (changes < posted.changes) {
    for (const auto& change : runner_.reader().changes(job, changes + 1, rpc::k_history_max)) {
      if (change.number > posted.changes) break;
      batch.changes.push_back(change_of(change));
      changes = change.number;
    }
  }
  runner_.watch(job);
  JobFeed::News news = runner_.feeds().of(job).after(point.event, point.mark, events_max);
  batch.events = std::move(news.events);
  batch.mark = news.mark;
  batch.settled = jobs::is_over(posted.job.state) && news.is_all && changes >= posted.changes;
  return batch;
}

void Calls::logs(const rpc::Caller& caller, rpc::LogAsk ask, rpc::Reply<rpc::LogPiece> reply) {
  const auto posted = look_up(caller, ask.job);
  if (!posted) {
    reply.refuse(posted.error());
    return;
  }
  try {
    rpc::LogPiece piece = logs_.read(runner_.folders().folder(job_id(ask.job)), ask);
    piece.is_over = jobs::is_over(posted.value()->job.state);
    reply.answer(std::move(piece));
  } catch (const base::Error& failure) {
    logging::warn(failure.what());
    reply.refuse({.kind = rpc::RefusalKind::environment,
                  .sentence = "The job's log can't be read.",
                  .what_to_do = "See the service's log for the reason."});
  }
}

/// Returns the request of an extended job. None: the machine no longer has the job and will refuse
/// the change.
base::Result<std::optional<StoredRequest>, rpc::Refusal> Calls::longer_request(
    jobs::JobId job, const rpc::Extension& extension) const {
  const jobs::Job* known = runner_.machine().find(job);
  if (known == nullptr) return std::optional<StoredRequest>();
  const std::uint64_t has = std::max(known->counts.solutions, known->counts.found);
  if (extension.by == rpc::ExtendBy::solutions && extension.to <= static_cast<double>(has)) {
    return rpc::Refusal{.kind = rpc::RefusalKind::bad_request,
                        .sentence = fmt::format("Job {} already has {} solutions.", job.value, has),
                        .what_to_do = "Request a higher number. No job was changed."};
  }
  const auto stored = runner_.reader().request(job, known->revision);
  if (!stored) {
    return rpc::Refusal{
        .kind = rpc::RefusalKind::busy,
        .sentence = fmt::format("Another change of job {} is in progress.", job.value),
        .what_to_do = "Try again."};
  }
  auto longer = extended_request(*stored, extension, read_, facts_.request_limits);
  if (!longer) return longer.error();
  return std::optional(std::move(longer).value());
}

/// Changes each job and answers when all changes are durable. If the target is a single job that
/// can't be changed, refuses the call. If the target is a group, answers for each job.
void Calls::change(const rpc::Caller& caller, rpc::ChangeAsk ask,
                   rpc::Reply<std::vector<rpc::Touched>> reply) {
  const auto found = jobs_of(caller, ask.target);
  if (!found) {
    reply.refuse(found.error());
    return;
  }
  if (ask.kind == rpc::ChangeKind::resume || ask.kind == rpc::ChangeKind::extend) {
    if (auto refused = may_not_revive(caller, found.value())) {
      reply.refuse(*std::move(refused));
      return;
    }
  }
  std::vector<std::optional<StoredRequest>> requests(found.value().size());
  for (std::size_t i = 0; ask.kind == rpc::ChangeKind::extend && i < requests.size(); ++i) {
    auto longer = longer_request(found.value()[i], ask.extension);
    if (!longer) {
      reply.refuse(longer.error());
      return;
    }
    requests[i] = std::move(longer).value();
  }
  if (!runner_.stalled().empty()) {
    reply.refuse(stalled());
    return;
  }
  struct Owed {
    rpc::Reply<std::vector<rpc::Touched>> reply;
    std::vector<rpc::Touched> touched{};
    std::size_t left = 0;
  };
  auto owed = std::make_shared<Owed>(Owed{.reply = std::move(reply), .left = requests.size()});
  owed->touched.resize(requests.size());
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const jobs::JobId job = found.value()[i];
    const bool is_alone = requests.size() == 1;
    runner_.ask(
        {.token = 0,
         .user = jobs::UserId{caller.user},
         .is_operator = is_operator(caller),
         .job = job,
         .kind = ask_kind(ask.kind),
         .priority = ask.priority},
        [this, owed, i, job, is_alone](const jobs::Answer& answer) {
          if (answer.refusal && is_alone) {
            owed->reply.refuse(refusal_of(*answer.refusal));
            return;
          }
          owed->touched[i] = touched_of(job, runner_.board(),
                                        answer.refusal ? answer.refusal->sentence : std::string());
          if (--owed->left == 0) owed->reply.answer(std::move(owed->touched));
        },
        std::move(requests[i]));
  }
}

void Calls::fetch(const rpc::Caller& caller, rpc::FetchAsk ask, rpc::Reply<rpc::Fetched> reply) {
  const auto posted = look_up(caller, ask.job);
  if (!posted) {
    reply.refuse(posted.error());
    return;
  }
  const StoredRequest& asked = posted.value()->asked;
  const bool is_search = asked.found_wanted > 0 && asked.in_proportion_wanted == 0;
  fetching_.fetch(caller.user, ask, is_search ? "find_segments" : "segments", std::move(reply));
}

void Calls::info(const rpc::Caller& caller, rpc::Reply<rpc::ServerView> reply) {
  const jobs::Standing standing = runner_.machine().standing();
  rpc::ServerView server;
  server.version = facts_.version;
  server.results_version = facts_.results_version;
  server.state_folder = runner_.options().state;
  server.pid = ::getpid();
  server.up_s = clock_.now_s() - begin_s_;
  server.draining = standing.is_draining;
  server.backend = facts_.backend;
  server.address = facts_.address;
  server.fingerprint = facts_.fingerprint;
  server.cores = standing.cores;
  server.cores_used = standing.cores_in_use;
  server.memory_bytes = standing.memory_bytes;
  server.memory_used_bytes = standing.memory_in_use;
  server.disk_free_bytes = disk_free_bytes(runner_.options().state);
  server.disk_reserve_bytes = runner_.options().disk_reserve_bytes;
  server.keeping_rule = facts_.keeping_rule;
  server.limits = facts_.limits;
  if (!runner_.stalled().empty())
    server.limits.push_back({.name = "stalled", .value = stalled().sentence});
  std::map<jobs::State, std::uint64_t> counts;
  for (const auto& [id, posted] : runner_.board().all())
    if (!posted.job.is_leaving && sees(caller, posted)) ++counts[posted.job.state];
  for (const auto& [state, count] : counts)
    server.counts.push_back({.state = rpc_state(state), .count = count});
  reply.answer(std::move(server));
}

void Calls::drain(const rpc::Caller& caller, rpc::Reply<rpc::Nothing> reply) {
  if (!is_operator(caller)) {
    reply.refuse({.kind = rpc::RefusalKind::not_allowed,
                  .sentence = "Only the user who runs the service can drain it."});
    return;
  }
  runner_.drain(true);
  reply.answer({});
}

void Calls::stop(const rpc::Caller& caller, rpc::Reply<rpc::Nothing> reply) {
  if (!is_operator(caller)) {
    reply.refuse({.kind = rpc::RefusalKind::not_allowed,
                  .sentence = "Only the user who runs the service can stop it."});
    return;
  }
  reply.answer({});
  stop_();
}

void Calls::listens_at(std::string address, std::string fingerprint) {
  facts_.address = std::move(address);
  facts_.fingerprint = std::move(fingerprint);
}

}  // namespace sleight::daemon
