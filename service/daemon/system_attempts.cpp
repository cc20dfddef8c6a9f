#include "service/daemon/system_attempts.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/logging/log.h"
#include "common/store/lease_files.h"
#include "service/keeper/keeper_lock.h"

namespace sleight::daemon {
namespace {

/// Returns whether a stop may have caused this end. Otherwise the run ended by itself.
bool may_be_stopped(const keeper::AttemptEnd& end) {
  return !end.run_end || end.run_end->end == events::End::stop_requested ||
         end.run_end->end == events::End::time_limit;
}

/// Opens the folder, so that a shared disk loads its newest state.
void refresh(const base::FileSystem& files, const std::string& folder) {
  try {
    static_cast<void>(files.names_in(folder));
  } catch (const base::Error&) {
    // Ignore the error: reading the record will report it.
  }
}

}  // namespace

bool LeaseWatch::may_live(double now_s) {
  try {
    if (!base::PosixFileSystem().exists(run_folder_)) return false;
    store::PosixLeaseFiles files(run_folder_, store::this_process());
    const auto generations = files.list();
    if (generations.empty()) return false;
    const auto text = files.read(generations.back());
    if (!text) return true;  // the file is being replaced
    const auto lease = store::LeaseText::from_text(*text);
    if (lease && (lease->is_released || files.is_gone(lease->holder))) return false;
    if (generations.back() != generation_ || *text != text_) {
      generation_ = generations.back();
      text_ = *text;
      since_s_ = now_s;
    }
    const double lease_s =
        lease ? std::min(lease->lease_s, store::k_lease_s_max) : store::k_lease_s;
    return now_s - since_s_ < lease_s;
  } catch (const base::Error&) {
    return true;
  }
}

SystemAttempts::SystemAttempts(Parts parts)
    : parts_(std::move(parts)),
      sights_({.clock = parts_.clock,
               .folders = parts_.folders,
               .feeds = parts_.feeds,
               .programs = parts_.programs}) {
  CHECK(backend::is_daemon_name(parts_.daemon_id));
}

SystemAttempts::~SystemAttempts() {
  parts_.backend->end_soon();
}

void SystemAttempts::tell(jobs::Input input) {
  parts_.loop.post([this, input = std::move(input)]() mutable { parts_.hear(std::move(input)); });
}

void SystemAttempts::tell_seen(jobs::JobId job, Run& run, decltype(jobs::Sight::seen) seen) {
  run.is_looked_for = false;
  tell(jobs::Sight{.job = job, .attempt = run.attempt, .seen = std::move(seen)});
}

void SystemAttempts::tell_pending(jobs::JobId job, Run& run, std::string words) {
  if (!run.is_looked_for && words == run.told_words) return;
  run.told_words = words;
  tell_seen(job, run, jobs::Pending{.words = std::move(words)});
}

backend::AttemptName SystemAttempts::name_of(jobs::JobId job, jobs::Attempt attempt) const {
  return {.daemon = parts_.daemon_id, .job = job.value, .epoch = attempt.value};
}

SystemAttempts::Run* SystemAttempts::find(jobs::JobId job, jobs::Attempt attempt) {
  const auto run = runs_.find(job);
  return run == runs_.end() || run->second.attempt != attempt ? nullptr : &run->second;
}

/// Returns the attempt's entry. Creates it if necessary. Drops an older attempt's entry.
SystemAttempts::Run& SystemAttempts::run_of(jobs::JobId job, jobs::Attempt attempt) {
  if (Run* run = find(job, attempt)) return *run;
  Run& run = runs_[job];
  run = Run();
  run.attempt = attempt;
  run.since_list = lists_;
  run.watched.is_found = true;
  plan_poll();
  return run;
}

void SystemAttempts::ask(std::function<void()> question) {
  worker_.run(std::move(question));
}

backend::Order SystemAttempts::order_of(const jobs::Launch& launch, const LaunchText& text) const {
  const std::uint64_t cache_bytes =
      launch.memory_bytes > k_process_bytes ? launch.memory_bytes - k_process_bytes : 0;
  const keeper::AttemptSpec spec{
      .folder = parts_.folders.folder(launch.job),
      .attempt = static_cast<std::uint32_t>(launch.attempt.value),
      .cores = std::max(1U, launch.cores),
      .ranks = launch.ranks,
      .in_batch = true,
      .cache_mb = cache_bytes >> 20U,
      .strict = text.strict,
  };
  if (const std::string obstacle = keeper::obstacle_of(spec, parts_.programs); !obstacle.empty())
    throw base::Error(obstacle);
  return {.name = name_of(launch.job, launch.attempt),
          .folder = spec.folder,
          .command = keeper::keeper_command_of(spec, parts_.programs),
          .label = fmt::format("sleight-{}", launch.job.value),
          .cores = spec.cores,
          .ranks = spec.ranks,
          .memory_bytes = launch.memory_bytes * std::max(1U, launch.ranks),
          .options = text.options};
}

void SystemAttempts::launch(const jobs::Launch& launch) {
  Run& run = run_of(launch.job, launch.attempt);
  run.is_launching = true;
  run.watched.is_found = false;
  try {
    if (auto note = sights_.look_at_programs()) tell(*std::move(note));
    const LaunchText text = parts_.text_of(launch.job, launch.revision);
    parts_.folders.write_request(launch.job, text.request, parts_.files);
    ask([this, job = launch.job, attempt = launch.attempt, order = order_of(launch, text)] {
      try {
        const backend::Seen seen = parts_.backend->launch(order);
        parts_.loop.post([this, job, attempt, seen] { launched(job, attempt, seen); });
      } catch (const backend::Away& away) {
        parts_.loop.post([this, job, attempt, words = std::string(away.what()),
                          may_have_begun = away.may_have_begun()] {
          not_launched(job, attempt, words, true, may_have_begun);
        });
      } catch (const base::Error& failure) {
        parts_.loop.post([this, job, attempt, words = std::string(failure.what())] {
          not_launched(job, attempt, words, false, false);
        });
      }
    });
  } catch (const base::Error& failure) {
    runs_.erase(launch.job);
    tell(sights_.launch_failed(launch.job, launch.attempt, failure.what()));
  }
}

void SystemAttempts::launched(jobs::JobId job, jobs::Attempt attempt, const backend::Seen& seen) {
  Run* run = find(job, attempt);
  if (run == nullptr) return;
  run->is_launching = false;
  run->since_list = lists_;  // a list in progress began before
  run->seen = seen;
  judge(job);
}

void SystemAttempts::not_launched(jobs::JobId job, jobs::Attempt attempt, const std::string& words,
                                  bool is_away, bool may_have_begun) {
  Run* run = find(job, attempt);
  if (run == nullptr) return;
  run->is_launching = false;
  run->since_list = lists_;
  logging::warn(fmt::format("job {}: {}", job.value, words));
  if (may_have_begun) {
    tell_seen(job, *run,
              jobs::Unknown{
                  .words = fmt::format("{} does not respond: {}", parts_.backend->title(), words)});
    return;
  }
  jobs::LaunchFailed failed = sights_.launch_failed(job, attempt, words);
  failed.is_backend_away = is_away;
  runs_.erase(job);
  tell(std::move(failed));
}

void SystemAttempts::stop(const jobs::Stop& stop) {
  if (Run* run = find(stop.job, stop.attempt)) run->is_stopped = true;
  const keeper::Stop how =
      stop.how == jobs::StopHow::now ? keeper::Stop::now : keeper::Stop::in_order;
  ask([this, name = name_of(stop.job, stop.attempt), how] {
    try {
      // If the attempt was still queued, only list() can show its end.
      if (parts_.backend->signal(name, how)) parts_.loop.post([this] { list(); });
    } catch (const base::Error& failure) {
      // The machine repeats the stop.
      logging::warn(fmt::format("job {}: {}", name.job, failure.what()));
    }
  });
}

void SystemAttempts::look(const jobs::Look& look) {
  run_of(look.job, look.attempt).is_looked_for = true;
  if (!list_begun_s_ || parts_.clock.now_s() - *list_begun_s_ >= list_soonest_s()) list();
}

double SystemAttempts::list_soonest_s() const {
  return k_list_soonest_share * parts_.list_every_s;
}

void SystemAttempts::list_if_due() {
  const bool is_looked_for =
      std::ranges::any_of(runs_, [](const auto& entry) { return entry.second.is_looked_for; });
  if (parts_.backend->are_lists_cheap() || is_looked_for || !list_begun_s_ ||
      parts_.clock.now_s() - *list_begun_s_ >= parts_.list_every_s)
    list();
}

/// Requests a list, unless one is in progress.
void SystemAttempts::list() {
  if (is_listing_) return;
  is_listing_ = true;
  list_begun_s_ = parts_.clock.now_s();
  ask([this, number = ++lists_] {
    try {
      const auto all = parts_.backend->list(parts_.daemon_id);
      parts_.loop.post([this, number, all] { listed(number, all); });
    } catch (const base::Error& failure) {
      parts_.loop.post([this, words = std::string(failure.what())] { not_listed(words); });
    }
  });
}

void SystemAttempts::listed(std::uint64_t number,
                            const std::map<backend::AttemptName, backend::Seen>& all) {
  is_listing_ = false;
  std::vector<jobs::JobId> open;
  for (auto& [job, run] : runs_) {
    if (run.is_launching || number <= run.since_list) continue;
    const auto found = all.find(name_of(job, run.attempt));
    run.seen = found == all.end() ? backend::Seen() : found->second;
    open.push_back(job);
  }
  for (const jobs::JobId job : open)
    judge(job);
}

void SystemAttempts::not_listed(const std::string& words) {
  is_listing_ = false;
  for (auto& [job, run] : runs_) {
    if (!run.is_looked_for) continue;
    tell_seen(job, run,
              jobs::Unknown{
                  .words = fmt::format("{} does not respond: {}", parts_.backend->title(), words)});
  }
}

void SystemAttempts::plan_poll() {
  const bool wants = !runs_.empty();
  if (wants == is_polling_) return;
  is_polling_ = wants;
  polling_ =
      wants ? parts_.loop.call_every(parts_.look_every_s, [this] { poll(); }) : rpc::Loop::Handle();
  listing_ = wants ? parts_.loop.call_every(list_soonest_s(), [this] { list_if_due(); })
                   : rpc::Loop::Handle();
}

void SystemAttempts::poll() {
  std::vector<jobs::JobId> open;
  for (const auto& [job, run] : runs_)
    open.push_back(job);
  for (const jobs::JobId job : open)
    judge(job);
  plan_poll();
}

bool SystemAttempts::is_gone(const Run& run) const {
  return run.seen && !run.is_launching &&
         (run.seen->state == backend::State::gone || run.seen->state == backend::State::absent);
}

jobs::Outside SystemAttempts::outside_of(const Run& run) const {
  if (!run.seen || run.is_stopped || run.seen->state != backend::State::gone)
    return jobs::Outside::nothing;
  // If the system takes an attempt away before it begins, count a failure. Otherwise this might
  // repeat forever.
  if (run.seen->cause == backend::Cause::taken)
    return run.has_begun ? jobs::Outside::taken : jobs::Outside::nothing;
  return run.seen->cause == backend::Cause::cancelled ? jobs::Outside::cancelled
                                                      : jobs::Outside::nothing;
}

std::string SystemAttempts::words_of(const Run& run) const {
  const std::string title = parts_.backend->title();
  if (!run.seen || run.seen->state == backend::State::absent)
    return fmt::format(
        "{} no longer lists the job, and the job's keeper left no record of the job's end", title);
  return fmt::format("{} job {}: {}", title, run.seen->id, run.seen->words);
}

/// Judges the attempt by the system's answer and by the folder's record. Reports the result.
void SystemAttempts::judge(jobs::JobId job) {
  const auto found = runs_.find(job);
  if (found == runs_.end()) return;
  Run& run = found->second;
  const std::string folder = parts_.folders.folder(job);
  if (is_gone(run)) refresh(parts_.files, folder);
  std::optional<keeper::AttemptRecord> record;
  try {
    record = keeper::read_record(folder);
    if (record && record->attempt > run.attempt.value)
      throw base::Error(
          fmt::format("{}: attempt {} has begun after attempt {}; another server uses this folder",
                      folder, record->attempt, run.attempt.value));
  } catch (const base::Error& failure) {
    if (run.is_looked_for) {
      logging::warn(fmt::format("job {}: {}", job.value, failure.what()));
      tell_seen(job, run, jobs::Unknown{});
    }
    return;
  }
  if (record && record->attempt != run.attempt.value) record.reset();
  const bool is_over = (record && judge_begun(job, run, *record)) || is_folder_gone(job, run) ||
                       (is_gone(run) && judge_gone(job, run, record ? &*record : nullptr));
  if (is_over) {
    runs_.erase(job);
  } else if (!is_gone(run)) {
    judge_there(job, run);
  }
}

/// Returns whether the attempt has ended.
bool SystemAttempts::judge_begun(jobs::JobId job, Run& run, const keeper::AttemptRecord& record) {
  if (!run.has_begun) {
    run.has_begun = true;
    run.watched = sights_.watch(job, run.watched.is_found);
    tell(jobs::Launched{.job = job, .attempt = run.attempt});
  }
  if (!record.end) return false;
  // If somebody else stopped the attempt, the system doesn't report this until the attempt is gone.
  if (may_be_stopped(*record.end) && !run.is_stopped && !is_gone(run)) return false;
  jobs::Ended ended = sights_.ended(job, record, run.watched.first_commit_after_s);
  ended.outside = outside_of(run);
  if (ended.outside != jobs::Outside::nothing) ended.outside_words = words_of(run);
  tell_seen(job, run, std::move(ended));
  return true;
}

/// Judges an attempt that is gone but has no recorded end. Returns whether the attempt is over.
bool SystemAttempts::judge_gone(jobs::JobId job, Run& run, const keeper::AttemptRecord* record) {
  const double now_s = parts_.clock.now_s();
  if (!run.gone_s) run.gone_s = now_s;
  if (now_s - *run.gone_s < parts_.settle_s) return false;
  if (record != nullptr) {
    // The run may still be alive on a machine to which the system lost contact.
    if (!run.lease) run.lease.emplace(parts_.folders.run(job));
    if (run.lease->may_live(now_s)) return false;
    jobs::Died died = sights_.died(job, record, words_of(run) + ".");
    died.outside = outside_of(run);
    tell_seen(job, run, std::move(died));
    return true;
  }
  const bool had_begun = keeper::KeeperLock::has_begun(
      parts_.folders.folder(job), static_cast<std::uint32_t>(run.attempt.value));
  if (run.seen->state == backend::State::gone || had_begun) {
    if (!std::exchange(run.is_told_gone, true)) fetch_last_words(job, run);
    return false;
  }
  if (run.is_looked_for) {
    tell_seen(job, run, jobs::NeverBegan{});
    run.gone_s.reset();
  }
  return false;
}

/// Fetches the output of the system and the keeper. If an attempt has no record, nothing else tells
/// about it.
void SystemAttempts::fetch_last_words(jobs::JobId job, Run& run) {
  ask([this, job, attempt = run.attempt, folder = parts_.folders.folder(job)] {
    std::string log;
    try {
      log = parts_.backend->log(name_of(job, attempt), folder, k_system_log_bytes);
    } catch (const base::Error& failure) {
      logging::warn(fmt::format("job {}: {}", job.value, failure.what()));
    }
    parts_.loop.post([this, job, attempt, log = std::move(log)] {
      Run* then = find(job, attempt);
      if (then == nullptr) return;
      jobs::Died died = sights_.died(job, nullptr, words_of(*then) + ".");
      died.log_end = log;
      died.outside = outside_of(*then);
      tell_seen(job, *then, std::move(died));
      runs_.erase(job);
    });
  });
}

/// Judges an attempt that the system has or may still have.
void SystemAttempts::judge_there(jobs::JobId job, Run& run) {
  run.gone_s.reset();
  if (run.has_begun) {
    if (run.is_looked_for) {
      tell_seen(job, run, sights_.running(job, run.watched));
    } else if (auto news = sights_.news(job, run.watched, parts_.clock.now_s())) {
      tell_seen(job, run, *std::move(news));
    }
    return;
  }
  if (!run.seen || run.is_launching) return;
  const std::string job_words = fmt::format("{} job {}", parts_.backend->title(), run.seen->id);
  if (run.seen->state == backend::State::waiting) {
    tell_pending(job, run, fmt::format("{} is waiting: {}", job_words, run.seen->words));
  } else if (run.seen->state == backend::State::running) {
    tell_pending(job, run,
                 fmt::format("{} has started, but the job's keeper has not started", job_words));
  } else if (run.is_looked_for) {
    tell_seen(job, run, jobs::Unknown{.words = fmt::format("{}: {}", job_words, run.seen->words)});
  }
}

/// If somebody deleted the run's folder, stops the run, because its results would be lost.
bool SystemAttempts::is_folder_gone(jobs::JobId job, Run& run) {
  if (!run.has_begun || parts_.files.exists(parts_.folders.folder(job))) return false;
  stop({.job = job, .attempt = run.attempt, .how = jobs::StopHow::now});
  tell_seen(
      job, run,
      jobs::Died{
          .words = "The job's folder was deleted.", .repeat = {}, .counts = {}, .disk_bytes = 0});
  parts_.feeds.drop(job);
  return true;
}

}  // namespace sleight::daemon
