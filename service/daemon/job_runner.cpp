#include "service/daemon/job_runner.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/logging/log.h"
#include "service/daemon/local_attempts.h"
#include "service/daemon/system_attempts.h"

namespace sleight::daemon {
namespace {

std::string store_path(const std::string& state) {
  return state + "/jobs.sqlite";
}

/// Removes and returns the step's save, if there is one.
std::optional<jobs::Save> take_save(std::vector<jobs::Effect>& effects) {
  if (effects.empty()) return std::nullopt;
  auto* save = std::get_if<jobs::Save>(&effects.front());
  if (save == nullptr) return std::nullopt;
  std::optional<jobs::Save> taken(std::move(*save));
  effects.erase(effects.begin());
  return taken;
}

/// Joins two steps into one step that has a single save.
void append(std::vector<jobs::Effect>& first, std::vector<jobs::Effect> second) {
  std::optional<jobs::Save> later = take_save(second);
  if (later) {
    if (first.empty() || !std::holds_alternative<jobs::Save>(first.front()))
      first.insert(first.begin(), jobs::Save());
    auto& save = std::get<jobs::Save>(first.front());
    const auto move_all = [](auto& to, auto& from) {
      std::move(from.begin(), from.end(), std::back_inserter(to));
    };
    move_all(save.jobs, later->jobs);
    move_all(save.changes, later->changes);
    move_all(save.erased, later->erased);
    move_all(save.usages, later->usages);
    save.clock_s = later->clock_s;
    save.next_id = later->next_id;
  }
  std::move(second.begin(), second.end(), std::back_inserter(first));
}

}  // namespace

double wall_s() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

JobRunner::JobRunner(rpc::Loop& loop, RunnerOptions options, News news, const store::RunLock* lock)
    : loop_(loop),
      options_(std::move(options)),
      news_(std::move(news)),
      folders_(options_.state),
      feeds_(folders_, clock_, [this](jobs::JobId job) { news_(job); }),
      backend_(options_.programs),
      saves_([&] {
        JobStore store(store_path(options_.state), lock);
        to_read_ = store.to_read();
        StoredJobs stored = store.load();
        // If somebody deleted the store, job folders remain. New jobs must not have the ids of
        // these folders.
        if (const std::uint64_t highest = folders_.highest(); highest >= stored.next_id) {
          logging::warn(
              fmt::format("{}: contains folders of jobs that are missing from the job store; the "
                          "highest has number {}, so the next new job gets number {}",
                          folders_.all(), highest, highest + 1));
          stored.next_id = highest + 1;
        }
        board_ = Board(stored);
        next_id_ = stored.next_id;
        machine_ = std::make_unique<jobs::Jobs>(options_.jobs,
                                                jobs::Restored{.clock_s = stored.clock_s,
                                                               .next_id = stored.next_id,
                                                               .jobs = std::move(stored.jobs),
                                                               .usages = std::move(stored.usages)});
        return std::make_unique<SaveQueue>(
            std::move(store),
            [this](SaveQueue::Callback callback) { loop_.post(std::move(callback)); },
            [this](const std::string& reason) {
              stalled_ = reason;
              logging::warn(reason.empty() ? "the job store is writable again" : reason);
            });
      }()),
      reader_(to_read_),
      attempts_(make_attempts()) {}

std::unique_ptr<Attempts> JobRunner::make_attempts() {
  const auto text_of = [this](jobs::JobId job, std::uint64_t revision) {
    const auto request = reader_.request(job, revision);
    if (!request)
      throw base::Error(fmt::format("the job store lacks the request of job {}", job.value));
    return LaunchText{
        .request = request->text, .strict = request->strict, .options = request->options};
  };
  const auto hear_it = [this](jobs::Input input) { hear(std::move(input)); };
  if (options_.system == nullptr) {
    return std::make_unique<LocalAttempts>(LocalAttempts::Parts{.loop = loop_,
                                                                .clock = clock_,
                                                                .files = files_,
                                                                .folders = folders_,
                                                                .feeds = feeds_,
                                                                .backend = backend_,
                                                                .text_of = text_of,
                                                                .hear = hear_it});
  }
  return std::make_unique<SystemAttempts>(SystemAttempts::Parts{.loop = loop_,
                                                                .clock = clock_,
                                                                .files = files_,
                                                                .folders = folders_,
                                                                .feeds = feeds_,
                                                                .backend = options_.system,
                                                                .daemon_id = options_.daemon_id,
                                                                .programs = options_.programs,
                                                                .text_of = text_of,
                                                                .hear = hear_it});
}

JobRunner::~JobRunner() = default;

void JobRunner::begin() {
  files_.make_folder(folders_.all());
  std::error_code reason;
  std::filesystem::remove_all(folders_.fetched(), reason);
  files_.make_folder(folders_.fetched());
  worker_.run([folders = folders_] { folders.clear_away(); });
  carry_out(step(jobs::Began{}));
  look_at_room();
  rooming_ = loop_.call_every(k_room_every_s, [this] { look_at_room(); });
}

void JobRunner::hear(jobs::Input input) {
  carry_out(step(input));
}

std::vector<jobs::Effect> JobRunner::step(const jobs::Input& input) {
  std::vector<jobs::Effect> effects =
      machine_->step(jobs::Tick{.now_s = clock_.now_s(), .wall = wall_s()});
  append(effects, machine_->step(input));
  return effects;
}

void JobRunner::carry_out(std::vector<jobs::Effect> effects, std::vector<StoredRequest> requests) {
  std::optional<jobs::Save> save = take_save(effects);
  if (save) next_id_ = save->next_id;
  if (save || pending_ > 0) {
    ++pending_;
    std::optional<Save> whole;
    if (save) whole = Save{.jobs = *std::move(save), .requests = std::move(requests)};
    saves_->put(whole, [this, whole, effects = std::move(effects)] {
      --pending_;
      durable(whole, effects);
    });
  } else {
    CHECK(requests.empty());
    durable(std::nullopt, effects);
  }
  plan_tick();
}

void JobRunner::durable(const std::optional<Save>& save, const std::vector<jobs::Effect>& effects) {
  std::vector<jobs::JobId> touched;
  if (save) touched = board_.take(*save);
  for (const jobs::Effect& effect : effects)
    perform(effect);
  for (const jobs::JobId job : touched)
    news_(job);
}

void JobRunner::perform(const jobs::Effect& effect) {
  if (const auto* launch = std::get_if<jobs::Launch>(&effect)) {
    attempts_->launch(*launch);
  } else if (const auto* stop = std::get_if<jobs::Stop>(&effect)) {
    attempts_->stop(*stop);
  } else if (const auto* look = std::get_if<jobs::Look>(&effect)) {
    attempts_->look(*look);
  } else if (const auto* said = std::get_if<jobs::Answer>(&effect)) {
    answer(*said);
  } else if (const auto* gone = std::get_if<jobs::Remove>(&effect)) {
    remove(gone->job);
  } else if (const auto* announced = std::get_if<jobs::Announce>(&effect)) {
    logging::info(
        fmt::format("job {} will be deleted by the rule for finished jobs; to prevent this, run "
                    "`sleight pin {}`",
                    announced->job.value, announced->job.value));
  }
}

void JobRunner::answer(const jobs::Answer& answer) {
  const auto owed = owed_.find(answer.token);
  if (owed == owed_.end()) return;
  const Answered answered = std::move(owed->second);
  owed_.erase(owed);
  answered(answer);
}

void JobRunner::remove(jobs::JobId job) {
  feeds_.drop(job);
  folders_.set_aside(job);
  worker_.run([this, folders = folders_, job] {
    folders.clear_away();
    loop_.post([this, job] { hear(jobs::Removed{.job = job}); });
  });
}

void JobRunner::submit(std::vector<Submission> submissions,
                       std::function<void(const std::vector<jobs::Answer>&)> answered) {
  // If one job is refused, refuse all.
  for (std::size_t i = 0; i < submissions.size(); ++i) {
    auto refusal = machine_->refusal_of(submissions[i].submit, i);
    if (!refusal) continue;
    answered({jobs::Answer{.token = 0, .job = {}, .is_new = false, .refusal = std::move(refusal)}});
    return;
  }

  // Submit each job, then save all at once.
  std::vector<jobs::Effect> effects;
  std::vector<jobs::Answer> answers;
  std::vector<StoredRequest> requests;
  for (Submission& submission : submissions) {
    submission.submit.token = next_token_++;
    std::vector<jobs::Effect> made = step(submission.submit);
    for (const jobs::Effect& effect : made) {
      const auto* answer = std::get_if<jobs::Answer>(&effect);
      if (answer == nullptr || answer->token != submission.submit.token) continue;
      answers.push_back(*answer);
      if (!answer->is_new) continue;
      submission.request.job = answer->job;
      requests.push_back(std::move(submission.request));
    }
    append(effects, std::move(made));
  }
  effects.emplace_back(jobs::Answer{.token = next_token_});
  owed_[next_token_++] = [answers = std::move(answers), answered = std::move(answered)](
                             const jobs::Answer&) { answered(answers); };
  carry_out(std::move(effects), std::move(requests));
}

void JobRunner::ask(jobs::Ask ask, Answered answered, std::optional<StoredRequest> request) {
  ask.token = next_token_++;
  owed_[ask.token] = std::move(answered);
  std::vector<jobs::Effect> effects = step(ask);
  std::vector<StoredRequest> requests;
  const jobs::Job* job = machine_->find(ask.job);
  const bool is_taken = request && job != nullptr && job->revision == request->revision;
  if (is_taken) requests.push_back(*std::move(request));
  carry_out(std::move(effects), std::move(requests));
}

void JobRunner::drain(bool on) {
  hear(jobs::Drain{.on = on});
}

void JobRunner::plan_tick() {
  const std::optional<double> next_s = machine_->next_tick_s();
  if (!next_s) {
    ticking_ = {};
    next_tick_s_ = -1;
    return;
  }
  if (*next_s == next_tick_s_) return;
  next_tick_s_ = *next_s;
  ticking_ = loop_.call_later(std::max(0.001, *next_s - clock_.now_s()), [this] {
    next_tick_s_ = -1;
    carry_out(machine_->step(jobs::Tick{.now_s = clock_.now_s(), .wall = wall_s()}));
  });
}

void JobRunner::look_at_room() {
  // Check the programs first, because they may start once Room is reported.
  if (auto note = attempts_->look_at_programs()) hear(*std::move(note));
  hear(jobs::Room{.cores = options_.cores,
                  .memory_bytes = options_.memory_bytes,
                  .disk_free_bytes = disk_free_bytes(options_.state),
                  .disk_reserve_bytes = options_.disk_reserve_bytes});
}

void JobRunner::watch(jobs::JobId job) {
  feeds_.watched(job);
  if (is_watching_) return;
  is_watching_ = true;
  watching_ = loop_.call_later(feeds_.watch_every_s(), [this] { look_at_watched(); });
}

/// Reads the logs of active watched runs.
void JobRunner::look_at_watched() {
  for (const jobs::JobId job : feeds_.watched_now()) {
    const Posted* posted = board_.find(job);
    if (posted == nullptr || !jobs::is_active(posted->job.state)) continue;
    feeds_.read(job, false);
  }
  const double next_s = feeds_.watch_every_s();
  is_watching_ = next_s > 0;
  watching_ =
      is_watching_ ? loop_.call_later(next_s, [this] { look_at_watched(); }) : rpc::Loop::Handle();
}

}  // namespace sleight::daemon
