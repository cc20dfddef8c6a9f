#include "tests/jobs/sim_backend.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "common/base/error.h"

namespace sleight::jobs::simulated {
namespace {

constexpr double k_latency_s_min = 1e-3, k_latency_s_max = 0.05;
/// Maximum delay of messages. Options::unbegun_max launches take longer than this delay.
constexpr double k_late_s_max = 8;

}  // namespace

void SimBackend::after(JobId job, double delay_s, void (SimBackend::*then)(JobId)) {
  events_.after(delay_s, [this, job, then, life = folders_.at(job).life] {
    const auto found = folders_.find(job);
    if (found != folders_.end() && found->second.life == life) (this->*then)(job);
  });
}

double SimBackend::latency_s() {
  return dice_.chance(weather_.late) ? dice_.uniform(0, k_late_s_max)
                                     : dice_.uniform(k_latency_s_min, k_latency_s_max);
}

void SimBackend::tell(Input input) {
  if (dice_.chance(weather_.wrong)) input = made_wrong(std::move(input));
  if (dice_.chance(weather_.lost)) return;
  if (dice_.chance(weather_.doubled)) events_.after(latency_s(), [this, input] { news_(input); });
  events_.after(latency_s(), [this, input = std::move(input)] { news_(input); });
}

Input SimBackend::made_wrong(Input input) {
  if (const auto* launched = std::get_if<Launched>(&input))
    return LaunchFailed{.job = launched->job, .attempt = launched->attempt, .words = "wrongly"};
  auto* sight = std::get_if<Sight>(&input);
  if (sight == nullptr) return input;
  switch (dice_.whole(0, 3)) {
    case 0:
      sight->seen = Died{};
      break;
    case 1:
      sight->seen = NeverBegan{};
      break;
    case 2:
      sight->job.value += 1'000'000;
      break;
    default:
      sight->attempt.value -= sight->attempt.value > 1 ? 1 : 0;
  }
  return input;
}

void SimBackend::launch(const Launch& launch) {
  if (dice_.chance(weather_.lost)) return;  // its keeper dies before it has the folder
  if (is_away_) {
    tell(LaunchFailed{.job = launch.job, .attempt = launch.attempt, .is_backend_away = true});
    return;
  }
  events_.after(latency_s(), [this, launch] { enqueue(launch); });
}

/// Queues an attempt. Does nothing if the attempt is queued already.
void SimBackend::enqueue(const Launch& launch) {
  const auto found = folders_.find(launch.job);
  if (found == folders_.end()) return;
  Folder& folder = found->second;
  if (folder.plan->queue_s <= 0) return begin(launch);
  if (folder.attempt >= launch.attempt || folder.cancelled >= launch.attempt) return;
  if (!folder.pending.emplace(launch.attempt, launch).second) return;
  tell(Sight{.job = launch.job, .attempt = launch.attempt, .seen = Pending{.words = "Priority"}});
  events_.after(dice_.uniform(0, 2 * folder.plan->queue_s), [this, launch] {
    const auto then = folders_.find(launch.job);
    if (then != folders_.end() && then->second.pending.erase(launch.attempt) > 0) begin(launch);
  });
}

/// Cancels a queued attempt. The attempt leaves no record.
void SimBackend::leave_queue(JobId job, Attempt attempt) {
  Folder& folder = folders_.at(job);
  folder.pending.erase(attempt);
  folder.cancelled = std::max(folder.cancelled, attempt);
  tell(Sight{.job = job, .attempt = attempt, .seen = Died{.outside = Outside::cancelled}});
}

void SimBackend::begin(const Launch& launch) {
  const auto found = folders_.find(launch.job);
  if (found == folders_.end()) return;
  Folder& folder = found->second;
  if (folder.is_locked || folder.attempt >= launch.attempt) return;  // K1, K2
  folder.is_locked = true;
  folder.attempt = launch.attempt;
  folder.end.reset();
  folder.outside = Outside::nothing;
  folder.revision = launch.revision;
  folder.cores = launch.cores;
  folder.is_stopping = false;
  folder.begin_s = events_.now_s();
  folder.first_commit_after_s.reset();
  ledger_.program_begins(launch.job, launch.attempt, launch.cores,
                         folder.plan->wishes.memory_of_all(), store_);
  tell(Launched{.job = launch.job, .attempt = launch.attempt});
  after(launch.job, folder.plan->begin_s, &SimBackend::go_on);
}

void SimBackend::go_on(JobId job) {
  Folder& folder = folders_.at(job);
  if (folder.plan->fate == Fate::is_refused) {
    end(job, {.kind = EndKind::failed,
              .exit_code = static_cast<int>(base::ExitCode::bad_request),
              .words = "refused"});
    return;
  }
  if (has_other_programs_ && folder.scans > 0) {
    end(job, {.kind = EndKind::failed,
              .exit_code = static_cast<int>(base::ExitCode::conflict),
              .hindrance = Hindrance::other_results,
              .words = "another results version"});
    return;
  }
  after(job, folder.plan->scan_core_s / folder.cores, &SimBackend::scan);
}

/// Commits a scan, or ends the program as planned.
void SimBackend::scan(JobId job) {
  Folder& folder = folders_.at(job);
  const std::uint64_t wanted = folder.plan->scans * folder.revision;
  if (folder.scans < wanted) {
    if (is_disk_full_) {
      end(job, {.kind = EndKind::failed,
                .exit_code = static_cast<int>(base::ExitCode::environment),
                .hindrance = Hindrance::disk_full,
                .words = "no space left"});
      return;
    }
    if (meets_fate(job, folder)) return;
    ++folder.scans;
    useful_core_s_ += folder.plan->scan_core_s;
    if (!folder.first_commit_after_s)
      folder.first_commit_after_s = events_.now_s() - folder.begin_s;
  }
  if (folder.scans < wanted) {
    tell(Sight{.job = job, .attempt = folder.attempt, .seen = seen_running(folder)});
    after(job, folder.plan->scan_core_s / folder.cores, &SimBackend::scan);
    return;
  }
  ledger_.is_finished(job, folder.revision);
  // mpirun's exit code is unreliable, because mpirun sometimes crashes after a finished run.
  end(job, {.kind = EndKind::finished, .exit_code = dice_.chance(0.2) ? 1 : 0, .digest = "all"});
}

bool SimBackend::meets_fate(JobId job, Folder& folder) {
  const JobPlan& plan = *folder.plan;
  if (folder.scans != plan.fate_scan || plan.fate == Fate::finishes) return false;
  switch (plan.fate) {
    case Fate::gives_up_with_finds:
      folder.found = 1;
      end(job, {.kind = EndKind::gave_up, .words = "found less"});
      return true;
    case Fate::gives_up:
      end(job, {.kind = EndKind::gave_up, .words = "found nothing"});
      return true;
    case Fate::no_draws:
      end(job, {.kind = EndKind::no_draws, .words = "no draws"});
      return true;
    case Fate::simulation_fails:
      end(job, {.kind = EndKind::simulation_failed,
                .exit_code = static_cast<int>(base::ExitCode::simulation_failed),
                .words = "a simulation failed"});
      return true;
    case Fate::bug_at_a_scan:
      end(job,
          {.kind = EndKind::bug, .exit_code = 134, .words = "1 against 2", .place = "a.cpp:7"});
      return true;
    case Fate::dies_at_a_scan:
      if (dice_.chance(0.5)) {
        die(job);
      } else {
        end(job, {.exit_code = dice_.chance(0.2) ? 0 : 137});
      }
      return true;
    case Fate::stops_by_itself:
      if (std::exchange(folder.has_stopped_by_itself, true)) return false;
      end(job, {.kind = EndKind::time_limit, .exit_code = 130});
      return true;
    default:
      return false;
  }
}

Running SimBackend::seen_running(const Folder& folder) const {
  return {.counts = {.scans = folder.scans, .found = folder.found},
          .first_commit_after_s = folder.first_commit_after_s,
          .disk_bytes = folder.plan->disk_bytes,
          .results_version = folder.scans > 0 ? "ours" : ""};
}

void SimBackend::release(JobId job, Folder& folder) {
  ++folder.life;
  folder.is_locked = false;
  const double core_s = folder.cores * (events_.now_s() - folder.begin_s);
  core_s_ += core_s;
  core_s_of_[folder.plan->user] += core_s;
  ledger_.program_ends(job, folder.attempt);
}

void SimBackend::end(JobId job, Ended ended) {
  Folder& folder = folders_.at(job);
  release(job, folder);
  ended.counts = {.scans = folder.scans, .found = folder.found};
  ended.first_commit_after_s = folder.first_commit_after_s;
  ended.disk_bytes = folder.plan->disk_bytes;
  folder.end = ended;
  tell(Sight{.job = job, .attempt = folder.attempt, .seen = std::move(ended)});
}

void SimBackend::die(JobId job, Outside outside) {
  Folder& folder = folders_.at(job);
  release(job, folder);
  folder.outside = outside;
  tell(Sight{
      .job = job,
      .attempt = folder.attempt,
      .seen = Died{.counts = {.scans = folder.scans, .found = folder.found}, .outside = outside}});
}

void SimBackend::stop(const Stop& stop) {
  if (dice_.chance(weather_.lost)) return;
  events_.after(latency_s(), [this, stop] {
    const auto found = folders_.find(stop.job);
    if (found != folders_.end() && found->second.pending.contains(stop.attempt))
      return leave_queue(stop.job, stop.attempt);
    if (found == folders_.end() || !found->second.is_locked ||
        found->second.attempt != stop.attempt)
      return;
    Folder& folder = found->second;
    if (stop.how == StopHow::now) {
      end(stop.job, {.signal = 9});
    } else if (!std::exchange(folder.is_stopping, true)) {
      ++folder.life;
      after(stop.job, folder.plan->stop_s, &SimBackend::stopped);
    }
  });
}

void SimBackend::stopped(JobId job) {
  end(job, {.kind = EndKind::stop_requested, .exit_code = 130, .digest = "so far"});
}

void SimBackend::look(const Look& look) {
  if (dice_.chance(weather_.lost)) return;
  events_.after(latency_s(), [this, look] {
    const auto found = folders_.find(look.job);
    Sight sight{.job = look.job, .attempt = look.attempt, .seen = NeverBegan{}};
    if (is_away_) {
      sight.seen = Unknown{};
    } else if (found != folders_.end()) {
      const Folder& folder = found->second;
      if (folder.is_locked || folder.attempt >= look.attempt) sight.attempt = folder.attempt;
      if (folder.is_locked) {
        sight.seen = seen_running(folder);
      } else if (folder.attempt >= look.attempt && folder.end) {
        sight.seen = *folder.end;
      } else if (folder.attempt >= look.attempt) {
        sight.seen = Died{.counts = {.scans = folder.scans, .found = folder.found},
                          .outside = folder.outside};
      } else if (folder.pending.contains(look.attempt)) {
        sight.seen = Pending{.words = "Resources"};
      } else if (folder.cancelled >= look.attempt) {
        sight.seen = Died{.outside = Outside::cancelled};
      }
    }
    tell(std::move(sight));
  });
}

void SimBackend::remove(JobId job) {
  if (dice_.chance(weather_.lost)) return;
  const auto found = folders_.find(job);
  if (found != folders_.end() && !found->second.is_locked) folders_.erase(found);
  tell(Removed{job});
}

void SimBackend::kill(std::uint64_t nth, bool all) {
  std::vector<JobId> locked;
  for (const auto& [job, folder] : folders_) {
    if (folder.is_locked) locked.push_back(job);
  }
  for (std::size_t i = 0; i < locked.size(); ++i) {
    if (all || i == nth % locked.size()) die(locked[i]);
  }
}

void SimBackend::take_place(std::uint64_t nth) {
  std::vector<JobId> locked;
  for (const auto& [job, folder] : folders_)
    if (folder.is_locked) locked.push_back(job);
  if (locked.empty()) return;
  const JobId job = locked[nth % locked.size()];
  if (nth % 2 == 0) {
    die(job, Outside::taken);
  } else {
    end(job, {.kind = EndKind::stop_requested, .exit_code = 130, .outside = Outside::taken});
  }
}

void SimBackend::cancel_by_hand(std::uint64_t nth) {
  std::vector<std::pair<JobId, std::optional<Attempt>>> there;
  for (const auto& [job, folder] : folders_) {
    if (folder.is_locked) there.emplace_back(job, std::nullopt);
    for (const auto& [attempt, launch] : folder.pending)
      there.emplace_back(job, attempt);
  }
  if (there.empty()) return;
  const auto& [job, waiting] = there[nth % there.size()];
  if (waiting) {
    leave_queue(job, *waiting);
  } else if (nth % 3 == 0) {
    die(job, Outside::cancelled);
  } else {
    end(job, {.kind = EndKind::stop_requested, .exit_code = 130, .outside = Outside::cancelled});
  }
}

double SimBackend::core_s_of(UserId user) const {
  const auto before = core_s_of_.find(user);
  double core_s = before == core_s_of_.end() ? 0 : before->second;
  for (const auto& [job, folder] : folders_) {
    if (folder.is_locked && folder.plan->user == user)
      core_s += folder.cores * (events_.now_s() - folder.begin_s);
  }
  return core_s;
}

bool SimBackend::anything_runs() const {
  for (const auto& [job, folder] : folders_) {
    if (folder.is_locked || !folder.pending.empty()) return true;
  }
  return false;
}

}  // namespace sleight::jobs::simulated
