#include "service/daemon/views.h"

#include <algorithm>
#include <optional>

#include "common/base/check.h"

namespace sleight::daemon {
namespace {

/// Estimates the seconds until the rest is found, at the average rate so far. None: no rate yet.
std::optional<double> left_s(std::uint64_t have, std::uint64_t wanted, double in_s) {
  if (wanted == 0 || have == 0 || in_s <= 0) return std::nullopt;
  if (have >= wanted) return 0;
  return in_s * static_cast<double>(wanted - have) / static_cast<double>(have);
}

void add_progress(rpc::JobView& view, const events::Progress& progress) {
  view.scans_total = progress.scans_total;
  view.solutions.found = std::max(view.solutions.found, progress.finds.found);
  view.solutions.in_proportion = std::max(view.solutions.in_proportion, progress.solutions);
  if (progress.elapsed_s <= 0) return;
  view.simulations_per_s = static_cast<double>(progress.session_simulations) / progress.elapsed_s;
  if (progress.scans_total > progress.scans_done && progress.session_scans > 0) {
    view.left_s = progress.elapsed_s *
                  static_cast<double>(progress.scans_total - progress.scans_done) /
                  static_cast<double>(progress.session_scans);
  }
}

/// Estimates the time left from the solutions and the run time of all attempts. The rate of a
/// single session would jump.
void add_time_left(rpc::JobView& view) {
  const double run_s = view.core_s / std::max(1U, view.ranks > 0 ? view.ranks : view.cores);
  const rpc::SolutionCounts& counts = view.solutions;
  const auto found_left = left_s(counts.found, counts.found_wanted, run_s);
  const auto left = left_s(counts.in_proportion, counts.in_proportion_wanted, run_s);
  view.solutions_left_s = counts.in_proportion_wanted > 0 ? left : found_left;
}

}  // namespace

rpc::JobId rpc_id(jobs::JobId job) {
  return rpc::JobId{job.value};
}

jobs::JobId job_id(rpc::JobId job) {
  return jobs::JobId{job.value};
}

rpc::JobState rpc_state(jobs::State state) {
  const auto found = rpc::job_state_of(jobs::name_of(state));
  CHECK(found.has_value());
  return *found;
}

// The two enumerations have the same values, but rpc's enumeration begins with `unknown`.
jobs::AskKind ask_kind(rpc::ChangeKind kind) {
  static_assert(static_cast<std::size_t>(jobs::AskKind::set_priority) + 2 == rpc::k_change_kinds);
  CHECK(kind != rpc::ChangeKind::unknown);
  return static_cast<jobs::AskKind>(static_cast<int>(kind) - 1);
}

std::string reason_of(const jobs::Job& job) {
  if (!job.words.empty()) return job.words;
  std::string words(jobs::name_of(job.reason));
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

rpc::JobView view_of(const ViewOf& what) {
  const jobs::Job& job = what.posted.job;
  const StoredRequest& asked = what.posted.asked;
  rpc::JobView view;
  view.id = rpc_id(job.id);
  if (job.group.value > 0) view.group = rpc::GroupId{job.group.value};
  view.user = job.user.value;
  view.name = job.name;
  view.world = asked.world;
  view.state = rpc_state(job.state);
  view.reason = reason_of(job);
  view.attempt = job.attempt.value;
  view.priority = job.priority;
  if (job.wishes.cores > 0) view.cores_wanted = job.wishes.cores;
  view.cores = jobs::is_active(job.state) ? job.cores : 0;
  view.ranks = job.wishes.ranks;
  view.memory_bytes = job.wishes.memory_of_all();
  view.strict = asked.strict;
  view.pinned = job.pinned;
  view.scans_done = job.counts.scans;
  view.solutions = {.found = job.counts.found,
                    .found_wanted = asked.found_wanted,
                    .in_proportion = job.counts.solutions,
                    .in_proportion_wanted = asked.in_proportion_wanted};
  for (const auto& [kind, count] : job.counts.failures)
    view.failures.push_back({.simulation = kind, .count = count});
  view.core_s = job.core_seconds;
  view.submitted_s = job.submitted_wall;
  view.started_s = job.began_wall;
  view.ended_s = job.over_wall;
  view.bytes = job.disk_bytes;
  view.deleted_at_s = job.remove_wall;
  view.digest = job.digest;
  view.results_version = job.results_version;
  if (what.progress != nullptr && jobs::is_active(job.state)) add_progress(view, *what.progress);
  if (jobs::is_active(job.state)) add_time_left(view);
  const jobs::Job* known = what.machine.find(job.id);
  if (job.state == jobs::State::queued && known != nullptr && known->state == jobs::State::queued) {
    const jobs::Waiting waiting = what.machine.waiting(job.id);
    view.place = waiting.place;
    view.not_yet = waiting.sentence;
  }
  if (jobs::is_over(job.state)) view.end_words = job.words;
  return view;
}

rpc::StateChange change_of(const JobReader::NumberedChange& change) {
  std::string words = change.change.words;
  if (words.empty()) {
    words = jobs::name_of(change.change.reason);
    std::replace(words.begin(), words.end(), '_', ' ');
  }
  return {.number = change.number,
          .time_s = change.change.wall,
          .state = rpc_state(change.change.to),
          .reason = std::move(words),
          .attempt = change.change.attempt.value};
}

rpc::Refusal refusal_of(const jobs::Refusal& refusal) {
  const auto kind = [&] {
    switch (refusal.kind) {
      case jobs::RefusalKind::not_found:
        return rpc::RefusalKind::not_found;
      case jobs::RefusalKind::not_allowed:
        return rpc::RefusalKind::not_allowed;
      case jobs::RefusalKind::key_in_use:
      case jobs::RefusalKind::wrong_state:
        return rpc::RefusalKind::conflict;
      case jobs::RefusalKind::over_limit:
      case jobs::RefusalKind::too_large:
        break;
    }
    return rpc::RefusalKind::limit;
  }();
  return {.kind = kind, .sentence = refusal.sentence, .what_to_do = refusal.what_to_do};
}

}  // namespace sleight::daemon
