#include "service/daemon/local_attempts.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/logging/log.h"

namespace sleight::daemon {

LocalAttempts::LocalAttempts(Parts parts)
    : parts_(std::move(parts)),
      sights_({.clock = parts_.clock,
               .folders = parts_.folders,
               .feeds = parts_.feeds,
               .programs = parts_.backend.programs()}) {}

void LocalAttempts::tell(jobs::Input input) {
  parts_.loop.post([this, input = std::move(input)]() mutable { parts_.hear(std::move(input)); });
}

void LocalAttempts::tell_launch_failed(jobs::JobId job, jobs::Attempt attempt,
                                       const std::string& words) {
  tell(sights_.launch_failed(job, attempt, words));
}

void LocalAttempts::launch(const jobs::Launch& launch) {
  const std::string folder = parts_.folders.folder(launch.job);
  try {
    if (auto note = sights_.look_at_programs()) tell(*std::move(note));
    const LaunchText text = parts_.text_of(launch.job, launch.revision);
    parts_.folders.write_request(launch.job, text.request, parts_.files);
    const std::uint64_t cache_bytes =
        launch.memory_bytes > k_process_bytes ? launch.memory_bytes - k_process_bytes : 0;
    const keeper::AttemptSpec spec{
        .folder = folder,
        .attempt = static_cast<std::uint32_t>(launch.attempt.value),
        .cores = std::max(1U, launch.cores),
        .ranks = launch.ranks,
        .cache_mb = cache_bytes >> 20U,
        .strict = text.strict,
    };
    follow(launch.job, launch.attempt, parts_.backend.launch(spec), false);
    await_begin(launch.job, launch.attempt);
  } catch (const base::Error& failure) {
    tell_launch_failed(launch.job, launch.attempt, failure.what());
  }
}

/// Waits for the keeper's record. If the keeper ends without a record, nothing has begun.
void LocalAttempts::await_begin(jobs::JobId job, jobs::Attempt attempt) {
  const auto run = running_.find(job);
  if (run == running_.end() || run->second.attempt != attempt || run->second.has_begun) return;
  if (look_whether_begun(job, attempt)) {
    run->second.has_begun = true;
    again_.erase(job);
    tell(jobs::Launched{.job = job, .attempt = attempt});
    return;
  }
  again_[job] =
      parts_.loop.call_later(k_again_s, [this, job, attempt] { await_begin(job, attempt); });
}

/// Returns whether the attempt has a record. If the folder belongs to another attempt, `see`
/// reports the error.
bool LocalAttempts::look_whether_begun(jobs::JobId job, jobs::Attempt attempt) {
  try {
    return parts_.backend
        .look(parts_.folders.folder(job), static_cast<std::uint32_t>(attempt.value))
        .record.has_value();
  } catch (const base::Error&) {
    return false;  // looks of the machine report the error
  }
}

void LocalAttempts::stop(const jobs::Stop& stop) {
  const keeper::Stop how =
      stop.how == jobs::StopHow::now ? keeper::Stop::now : keeper::Stop::in_order;
  try {
    // If this daemon launched the keeper, use its handle: it works even before the keeper has
    // written a record.
    const auto run = running_.find(stop.job);
    if (run != running_.end() && run->second.attempt == stop.attempt) {
      run->second.keeper->stop(how);
      return;
    }
    parts_.backend.stop(parts_.folders.folder(stop.job),
                        static_cast<std::uint32_t>(stop.attempt.value), how);
  } catch (const base::Error& failure) {
    logging::warn(fmt::format("job {}: {}", stop.job.value, failure.what()));
  }
}

void LocalAttempts::look(const jobs::Look& look) {
  see(look.job, look.attempt);
}

/// Reports the attempt's state, which its folder shows. If the attempt's keeper is running, begins
/// to wait for its end.
void LocalAttempts::see(jobs::JobId job, jobs::Attempt attempt) {
  const std::string folder = parts_.folders.folder(job);
  const auto number = static_cast<std::uint32_t>(attempt.value);
  jobs::Sight sight{.job = job, .attempt = attempt, .seen = jobs::Unknown{}};
  try {
    keeper::Look seen = parts_.backend.look(folder, number);
    using State = keeper::Look::State;
    if (seen.state == State::running) {
      if (!running_.contains(job)) {
        if (auto keeper = parts_.backend.adopt(folder, number)) {
          follow(job, attempt, *std::move(keeper), true);
        } else {
          // The keeper has just started or just exited, so look again a moment later.
          again_[job] =
              parts_.loop.call_later(k_again_s, [this, job, attempt] { see(job, attempt); });
          return;
        }
      }
    }
    switch (seen.state) {
      case State::never_began:
        sight.seen = jobs::NeverBegan{};
        break;
      case State::running: {
        const auto run = running_.find(job);
        sight.seen =
            run == running_.end() ? jobs::Running{} : sights_.running(job, run->second.watched);
        break;
      }
      case State::ended: {
        const auto run = running_.find(job);
        const auto after_s =
            run == running_.end() ? std::nullopt : run->second.watched.first_commit_after_s;
        sight.seen = sights_.ended(job, *seen.record, after_s);
        break;
      }
      case State::died:
        sight.seen = sights_.died(job, &*seen.record, "The job's keeper and program were killed.");
        break;
    }
    if (seen.state != State::running) running_.erase(job);
  } catch (const base::Error& failure) {
    logging::warn(fmt::format("job {}: {}", job.value, failure.what()));
  }
  tell(std::move(sight));
}

void LocalAttempts::follow(jobs::JobId job, jobs::Attempt attempt, keeper::RunningKeeper keeper,
                           bool is_found) {
  Run& run = running_[job];
  run = Run();
  run.attempt = attempt;
  run.has_begun = is_found;
  run.watched = sights_.watch(job, is_found);
  run.keeper = std::move(keeper);
  run.gone =
      parts_.loop.call_when_readable(run.keeper->descriptor(), [this, job] { keeper_gone(job); });
  plan_poll();
}

void LocalAttempts::keeper_gone(jobs::JobId job) {
  const auto run = running_.find(job);
  if (run == running_.end()) return;
  const jobs::Attempt attempt = run->second.attempt;
  const bool had_begun = run->second.has_begun;
  run->second.gone = {};
  if (had_begun || !tell_unbegun(job, attempt)) see(job, attempt);
  running_.erase(job);
}

/// Reports a failed launch if the keeper exited without a record.
bool LocalAttempts::tell_unbegun(jobs::JobId job, jobs::Attempt attempt) {
  again_.erase(job);
  try {
    const keeper::Look seen =
        parts_.backend.look(parts_.folders.folder(job), static_cast<std::uint32_t>(attempt.value));
    if (seen.state != keeper::Look::State::never_began) return false;
    tell_launch_failed(
        job, attempt,
        seen.words.empty() ? "the keeper exited before the attempt began" : seen.words);
    return true;
  } catch (const base::Error&) {
    return false;
  }
}

/// The youngest run determines how often to poll.
void LocalAttempts::plan_poll() {
  double every_s = 0;
  for (const auto& [job, run] : running_) {
    every_s = run.watched.is_young() ? k_look_young_s : every_s == 0 ? k_look_s : every_s;
  }
  if (every_s == poll_every_s_) return;
  poll_every_s_ = every_s;
  polling_ =
      every_s == 0 ? rpc::Loop::Handle() : parts_.loop.call_every(every_s, [this] { poll(); });
}

void LocalAttempts::poll() {
  const double now_s = parts_.clock.now_s();
  end_those_without_folder(now_s);
  for (auto& [job, run] : running_) {
    if (auto running = sights_.news(job, run.watched, now_s))
      tell(jobs::Sight{.job = job, .attempt = run.attempt, .seen = *std::move(running)});
  }
  plan_poll();
}

/// If a run's folder was deleted, stops the run, because its results would be lost.
void LocalAttempts::end_those_without_folder(double now_s) {
  std::vector<jobs::JobId> gone;
  for (const auto& [job, run] : running_) {
    if (run.has_begun && now_s - run.watched.looked_s >= k_look_s &&
        !parts_.files.exists(parts_.folders.folder(job)))
      gone.push_back(job);
  }
  for (const jobs::JobId job : gone) {
    const auto run = running_.find(job);
    run->second.keeper->stop(keeper::Stop::now);
    tell(jobs::Sight{.job = job,
                     .attempt = run->second.attempt,
                     .seen = jobs::Died{.words = "The job's folder was deleted.",
                                        .repeat = {},
                                        .counts = {},
                                        .disk_bytes = 0}});
    parts_.feeds.drop(job);
    running_.erase(run);
  }
}

}  // namespace sleight::daemon
