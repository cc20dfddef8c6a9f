#include "service/backend/slurm_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "common/base/check.h"

namespace sleight::backend {
namespace {

struct KnownState {
  std::string_view name;
  State state;
  Cause cause = Cause::itself;
};

/// From squeue(1), "JOB STATE CODES".
constexpr std::array<KnownState, 24> k_slurm_states{{
    {"PENDING", State::waiting},
    {"REQUEUED", State::waiting},
    {"REQUEUE_FED", State::waiting},
    {"REQUEUE_HOLD", State::waiting},
    {"RESV_DEL_HOLD", State::waiting},
    {"SPECIAL_EXIT", State::waiting},
    {"RUNNING", State::running},
    {"CONFIGURING", State::running},
    {"COMPLETING", State::running},
    {"RESIZING", State::running},
    {"SIGNALING", State::running},
    {"STAGE_OUT", State::running},
    {"STOPPED", State::running},
    {"SUSPENDED", State::running},
    {"COMPLETED", State::gone},
    {"FAILED", State::gone},
    {"TIMEOUT", State::gone},
    {"DEADLINE", State::gone},
    {"OUT_OF_MEMORY", State::gone},
    {"CANCELLED", State::gone, Cause::cancelled},
    {"PREEMPTED", State::gone, Cause::taken},
    {"NODE_FAIL", State::gone, Cause::taken},
    {"BOOT_FAIL", State::gone, Cause::taken},
    {"REVOKED", State::gone, Cause::taken},
}};

constexpr std::array<std::string_view, 3> k_taken_reasons{"JobLaunchFailure", "NodeDown",
                                                          "SystemFailure"};

bool is_number(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

/// Removes the text up to `mark` from the front of `rest` and returns it.
std::optional<std::string_view> take_to(std::string_view& rest, char mark) {
  const std::size_t end = rest.find(mark);
  if (end == rest.npos) return std::nullopt;
  const std::string_view field = rest.substr(0, end);
  rest.remove_prefix(end + 1);
  return field;
}

int weight_of(State state) {
  return state == State::running   ? 3
         : state == State::waiting ? 2
         : state == State::unknown ? 1
                                   : 0;
}

bool is_smaller_number(const std::string& a, const std::string& b) {
  return std::pair(a.size(), a) < std::pair(b.size(), b);
}

}  // namespace

Seen seen_of_slurm(std::string_view state, std::string_view reason) {
  const auto known = std::ranges::find(k_slurm_states, state, &KnownState::name);
  Seen seen{.state = State::unknown, .words = std::string(state)};
  if (known == k_slurm_states.end()) return seen;
  seen.state = known->state;
  seen.cause = known->cause;
  const bool has_reason = !reason.empty() && reason != "None";
  // If Slurm lost a job, it also reports FAILED, but with one of these reasons.
  if (seen.state == State::gone &&
      std::ranges::find(k_taken_reasons, reason) != std::end(k_taken_reasons))
    seen.cause = Cause::taken;
  if (seen.state == State::waiting && has_reason) {
    seen.words = reason;
  } else if (seen.state == State::gone && has_reason) {
    seen.words = fmt::format("{} ({})", state, reason);
  }
  return seen;
}

SlurmQueue slurm_queue_of(std::string_view text) {
  SlurmQueue queue;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto id = take_to(row, '|');
    const auto state = id ? take_to(row, '|') : std::nullopt;
    const auto reason = state ? take_to(row, '|') : std::nullopt;
    if (!reason || !is_number(*id)) continue;
    const auto name = attempt_name_of(row);
    if (!name) continue;
    SlurmJob job{.id = std::string(*id), .seen = seen_of_slurm(*state, *reason)};
    job.seen.id = job.id;
    queue[*name].push_back(std::move(job));
  }
  for (auto& [name, jobs] : queue)
    std::ranges::sort(jobs, is_smaller_number, &SlurmJob::id);
  return queue;
}

const SlurmJob& telling_one(const std::vector<SlurmJob>& jobs) {
  CHECK(!jobs.empty());
  const SlurmJob* best = &jobs.front();
  for (const SlurmJob& job : jobs)
    if (weight_of(job.seen.state) >= weight_of(best->seen.state)) best = &job;
  return *best;
}

std::string slurm_number_in(std::string_view text) {
  // The site's own messages may precede the job number.
  std::string number;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    // "812", or "812;cluster".
    const std::string_view first = line.substr(0, line.find(';'));
    if (is_number(first)) number = first;
  }
  return number;
}

bool says_away(std::string_view words) {
  constexpr std::array<std::string_view, 12> signs{
      "Unable to contact slurm controller",
      "Connection refused",
      "Connection timed out",
      "Connection reset",
      "Socket timed out",
      "Zero Bytes were transmitted",
      "Transport endpoint is not connected",
      "Communication connection failure",
      "Protocol authentication error",
      "Slurm backup controller in standby mode",
      "Slurm temporarily unable to accept job",
      "Unable to establish",
  };
  return std::ranges::any_of(
      signs, [words](std::string_view sign) { return words.find(sign) != words.npos; });
}

}  // namespace sleight::backend
