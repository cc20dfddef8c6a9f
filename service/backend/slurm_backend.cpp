#include "service/backend/slurm_backend.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "common/base/check.h"
#include "service/backend/slurm_options.h"

namespace sleight::backend {
namespace {

/// Slurm's messages if a job has ended or Slurm has forgotten it.
bool says_gone(const std::string& words) {
  return words.find("Invalid job id") != words.npos ||
         words.find("already completing or completed") != words.npos;
}

/// Slurm expands %j and similar patterns in file names, and interprets backslashes.
std::string without_patterns(const std::string& folder) {
  if (folder.find('\\') != folder.npos)
    throw base::Error(
        fmt::format("the folder '{}' contains a backslash, which Slurm does not support", folder));
  std::string text;
  for (const char c : folder)
    text += c == '%' ? std::string("%%") : std::string(1, c);
  return text;
}

}  // namespace

SlurmBackend::SlurmBackend(SlurmSettings settings, const base::Clock& clock)
    : settings_(std::move(settings)),
      clock_(clock),
      // The daemon may run in a Slurm job, and its user may have set squeue's variables.
      environment_(keeper::environment_without({"SBATCH_", "SQUEUE_", "SCANCEL_", "SLURM_"},
                                               {"SLURM_CONF"})) {
  slurm_wishes_of(settings_.defaults, {});
}

keeper::ToolEnd SlurmBackend::run(const std::vector<std::string>& command) {
  try {
    return keeper::run_tool(
        command,
        {.seconds_max = settings_.tool_s_max, .environment = environment_, .stop = &is_ending_});
  } catch (const base::Error& failure) {
    throw Away(failure.what());
  }
}

/// Returns the queue. `afresh`: query Slurm now; otherwise the queue may be up to list_every_s old.
const SlurmQueue& SlurmBackend::queue(bool afresh) {
  const double now_s = clock_.now_s();
  if (!afresh && asked_s_ && now_s - *asked_s_ < settings_.list_every_s) return queue_;
  // If a query got no answer, don't repeat it for each job.
  if (away_s_ && now_s - *away_s_ < settings_.list_every_s) throw Away(away_words_);
  try {
    ask(now_s);
    away_s_.reset();
  } catch (const Away& away) {
    away_s_ = clock_.now_s();
    away_words_ = away.what();
    throw;
  }
  return queue_;
}

void SlurmBackend::ask(double now_s) {
  const keeper::ToolEnd end = run({settings_.squeue, fmt::format("--user={}", ::getuid()),
                                   "--states=all", "--noheader", "-o", k_squeue_format});
  // If the queue were truncated, missing attempts would count as absent.
  if (end.exit_code != 0 || end.is_cut)
    throw Away(fmt::format("squeue: {}", end.is_cut ? "the output is too long" : end.why()));
  queue_ = slurm_queue_of(end.output);
  asked_s_ = now_s;
}

Seen SlurmBackend::seen_in(const SlurmQueue& queue, const AttemptName& name) const {
  const auto found = queue.find(name);
  if (found == queue.end()) return {};
  Seen seen = telling_one(found->second).seen;
  if (seen.cause == Cause::cancelled && cancelled_.contains(seen.id)) seen.cause = Cause::itself;
  return seen;
}

Seen SlurmBackend::state(const AttemptName& name) {
  return seen_in(queue(false), name);
}

std::map<AttemptName, Seen> SlurmBackend::list(const std::string& daemon) {
  const SlurmQueue& all = queue(false);
  std::map<AttemptName, Seen> listed;
  for (auto job = all.lower_bound({.daemon = daemon}); job != all.end(); ++job) {
    if (job->first.daemon != daemon) break;
    listed.emplace(job->first, seen_in(all, job->first));
  }
  return listed;
}

Seen SlurmBackend::launch(const Order& order) {
  check_order(order);
  // Search the queue first, because an earlier launch may have submitted the attempt.
  Seen before = seen_in(queue(unsure_.contains(order.name)), order.name);
  if (before.state == State::absent) {
    submit(order);
    before = seen_in(queue_, order.name);
  }
  unsure_.erase(order.name);
  return before;
}

std::vector<std::string> SlurmBackend::submission_of(const Order& order) const {
  const SlurmWishes wishes = slurm_wishes_of(settings_.defaults, order.options);
  const std::uint32_t tasks = std::max(1U, order.ranks);
  std::vector<std::string> command{
      settings_.sbatch,
      "--parsable",
      "--no-requeue",
      fmt::format("--comment={}", to_text(order.name)),
      fmt::format("--job-name={}", order.label.empty() ? to_text(order.name) : order.label),
      fmt::format("--chdir={}", order.folder),
      fmt::format("--output={}/{}", without_patterns(order.folder), k_slurm_log_name),
      "--open-mode=append",
      fmt::format("--ntasks={}", tasks),
      fmt::format("--cpus-per-task={}", order.ranks > 0 ? 1U : std::max(1U, order.cores)),
  };
  if (order.ranks == 0) command.emplace_back("--nodes=1");
  if (order.memory_bytes > 0 && !wishes.says_memory) {
    const std::uint64_t each_mb = (order.memory_bytes / tasks + 999'999) / 1'000'000;
    command.push_back(fmt::format("--{}={}M", order.ranks > 0 ? "mem-per-cpu" : "mem", each_mb));
  }
  command.insert(command.end(), wishes.arguments.begin(), wishes.arguments.end());
  command.insert(command.end(), {settings_.script, "--attempt"});
  command.insert(command.end(), order.command.begin(), order.command.end());
  return command;
}

void SlurmBackend::submit(const Order& order) {
  const std::vector<std::string> command = submission_of(order);
  unsure_.insert(order.name);
  const keeper::ToolEnd end = run(command);
  const std::string id = end.exit_code == 0 ? slurm_number_in(end.output) : std::string();
  if (id.empty()) {
    if (end.exit_code <= 0 || says_away(end.words))
      throw Away(fmt::format("sbatch: {}",
                             end.exit_code == 0 ? "the output has no job number" : end.why()),
                 true);
    unsure_.erase(order.name);
    throw base::Error(fmt::format("sbatch: {}", end.why()));
  }
  queue_[order.name].push_back(
      {.id = id, .seen = {.state = State::waiting, .id = id, .words = "submitted"}});
}

bool SlurmBackend::signal(const AttemptName& name, keeper::Stop how) {
  const SlurmQueue& all = queue(false);
  const auto found = all.find(name);
  if (found == all.end()) return false;
  bool any = false;
  for (const SlurmJob& job : found->second) {
    if (job.seen.state == State::gone) continue;
    const bool is_told = how == keeper::Stop::in_order && job.seen.state != State::waiting;
    std::vector<std::string> command{settings_.scancel};
    if (is_told) command.insert(command.end(), {"--signal=USR1", "--batch"});
    // With --state=PENDING, a job that has begun in the meantime isn't cancelled. A later signal
    // reaches that job's keeper.
    if (how == keeper::Stop::in_order && !is_told) command.emplace_back("--state=PENDING");
    command.push_back(job.id);
    const keeper::ToolEnd end = run(command);
    const bool is_gone = says_gone(end.words);
    if (end.exit_code != 0 && !is_gone) throw Away(fmt::format("scancel: {}", end.why()));
    if (!is_told && !is_gone) cancelled_.insert(job.id);
    any = any || !is_gone;
  }
  return any;
}

std::string SlurmBackend::log(const AttemptName&, const std::string& folder,
                              std::size_t bytes_max) {
  return end_of_file(folder + "/" + k_slurm_log_name, bytes_max);
}

}  // namespace sleight::backend
