#include "tests/jobs/scenario.h"

#include <fmt/format.h>

#include <algorithm>

#include "tests/cluster/dice.h"

namespace sleight::jobs::simulated {
namespace {

using cluster::Dice;

constexpr std::uint64_t k_gb = 1'000'000'000;

Fate fate_of(Dice& dice) {
  if (dice.chance(0.75)) return Fate::finishes;
  return static_cast<Fate>(dice.whole(1, static_cast<std::uint64_t>(Fate::stops_by_itself)));
}

std::vector<UserAct> acts_of(Dice& dice, double span_s) {
  std::vector<UserAct> acts;
  const double at_s = dice.uniform(0, span_s);
  if (dice.chance(0.08)) acts.push_back({.kind = AskKind::cancel, .at_s = at_s});
  if (dice.chance(0.08)) acts.push_back({.kind = AskKind::hold, .at_s = at_s});
  if (dice.chance(0.08)) acts.push_back({.kind = AskKind::extend, .at_s = at_s * 1.2});
  if (dice.chance(0.05)) acts.push_back({.kind = AskKind::pin, .at_s = at_s});
  if (dice.chance(0.05)) acts.push_back({.kind = AskKind::set_priority, .at_s = at_s});
  if (dice.chance(0.05)) acts.push_back({.kind = AskKind::remove, .at_s = at_s * 1.3});
  // In the end, users resume all held jobs and some cancelled jobs.
  if (!acts.empty() && (acts.front().kind == AskKind::hold || dice.chance(0.3)))
    acts.push_back({.kind = AskKind::resume, .at_s = at_s + dice.log_uniform(1, span_s)});
  return acts;
}

Wishes wishes_of(Dice& dice, const Room& room) {
  Wishes wishes;
  if (dice.chance(0.4)) wishes.cores = static_cast<std::uint32_t>(dice.whole(1, room.cores));
  if (dice.chance(0.2)) wishes.ranks = static_cast<std::uint32_t>(dice.whole(1, room.cores));
  wishes.memory_bytes = room.memory_bytes / wishes.processes();
  wishes.memory_bytes = static_cast<std::uint64_t>(static_cast<double>(wishes.memory_bytes) *
                                                   dice.log_uniform(0.01, 1));
  return wishes;
}

JobPlan job_of(Dice& dice, std::uint32_t users, const Room& room, double span_s) {
  JobPlan job;
  job.user = UserId{1000 + static_cast<std::uint32_t>(dice.whole(0, users - 1))};
  job.submitted_s = dice.uniform(0, span_s);
  job.is_submitted_twice = dice.chance(0.1);
  job.priority = static_cast<std::int32_t>(dice.whole(0, 2));
  job.wishes = wishes_of(dice, room);
  job.fate = fate_of(dice);
  job.scans = dice.whole(1, 30);
  job.fate_scan = dice.whole(0, job.scans - 1);
  job.scan_core_s = dice.log_uniform(0.02, 5);
  job.begin_s = dice.log_uniform(0.02, 1);
  job.stop_s = dice.log_uniform(0.02, 2);
  job.disk_bytes = dice.whole(1, 5) * k_gb;
  job.acts = acts_of(dice, 2 * span_s);
  if (dice.chance(0.3)) job.queue_s = dice.log_uniform(0.1, 30);
  return job;
}

std::vector<Fault> faults_of(std::uint64_t seed, double span_s,
                             const std::vector<Fault::Kind>& wants) {
  Dice dice(seed, Dice::Part::faults);
  std::vector<Fault> faults(dice.whole(0, k_faults_max));
  if (!wants.empty() && faults.size() < 20) faults.resize(20);
  // If no message is wrong, the ledger also checks that running programs are within the limits.
  const bool is_truthful = !wants.empty() || dice.chance(0.6);
  for (Fault& fault : faults) {
    fault.kind = static_cast<Fault::Kind>(
        dice.whole(0, static_cast<std::uint64_t>(Fault::Kind::machine_shrinks)));
    if (!wants.empty() && dice.chance(0.6)) fault.kind = wants[dice.whole(0, wants.size() - 1)];
    if (is_truthful && fault.kind == Fault::Kind::messages_wrong)
      fault.kind = Fault::Kind::messages_late;
    fault.at_s = dice.uniform(0, span_s);
    if (lasts(fault.kind)) fault.for_s = dice.log_uniform(0.1, span_s / 5);
    fault.odds = dice.log_uniform(0.01, 0.9);
    fault.which = dice.whole(0, 1'000'000);
  }
  return faults;
}

}  // namespace

bool lasts(Fault::Kind kind) {
  return kind != Fault::Kind::server_dies && kind != Fault::Kind::server_dies_at_save &&
         kind != Fault::Kind::keeper_dies && kind != Fault::Kind::wall_jumps &&
         kind != Fault::Kind::place_taken && kind != Fault::Kind::cancelled_by_hand;
}

bool Scenario::has(Fault::Kind kind) const {
  return std::ranges::any_of(faults, [kind](const Fault& fault) { return fault.kind == kind; });
}

std::string Scenario::name() const {
  return fmt::format("seed {}: {} jobs, {} cores, {} faults", seed, jobs.size(), room.cores,
                     faults.size());
}

Scenario scenario_of(std::uint64_t seed, const ScenarioChoice& choice) {
  Dice dice(seed, Dice::Part::scenario);
  Scenario scenario;
  scenario.seed = seed;
  scenario.mistake = choice.mistake;
  const auto jobs =
      static_cast<std::uint64_t>(dice.log_uniform(1, static_cast<double>(choice.jobs_max) + 0.5));
  const auto users = static_cast<std::uint32_t>(dice.whole(1, k_users_max));
  Room& room = scenario.room;
  room.cores = static_cast<std::uint32_t>(dice.log_uniform(1, 64.5));
  room.memory_bytes = 64 * k_gb;
  room.disk_free_bytes = 100 * k_gb;
  room.disk_reserve_bytes = 10 * k_gb;

  Options& options = scenario.options;
  options.patience_s = dice.log_uniform(60, 3600);
  options.keep_s = dice.log_uniform(300, 86400);
  options.announce_s = dice.log_uniform(10, 100);
  options.keep_bytes = dice.whole(10, 2000) * k_gb;
  options.look_every_s = dice.log_uniform(2, 30);
  if (dice.chance(0.3)) options.limits.jobs = std::max<std::uint64_t>(1, jobs / users);
  if (dice.chance(0.3))
    options.limits.cores = static_cast<std::uint32_t>(dice.whole(1, room.cores));

  const double span_s =
      choice.are_deleted ? 300 : dice.log_uniform(10, 20 + static_cast<double>(jobs));
  double last_s = span_s;
  for (std::uint64_t i = 0; i < jobs; ++i) {
    JobPlan& job = scenario.jobs.emplace_back(job_of(dice, users, room, span_s));
    // If a job needed more cores than the limit, the service would refuse it.
    if (options.limits.cores > 0)
      job.wishes.ranks = std::min(job.wishes.ranks, options.limits.cores);
    if (choice.are_deleted) {
      job.acts.clear();
      for (const double after_s : {5, 15, 30, 60, 120})
        job.acts.push_back({.kind = AskKind::remove, .at_s = job.submitted_s + after_s});
    }
    for (const UserAct& act : job.acts)
      last_s = std::max(last_s, act.at_s);
  }
  if (dice.chance(0.2)) {
    double core_s = 0;
    for (const JobPlan& job : scenario.jobs)
      core_s += job.scan_core_s * static_cast<double>(job.scans);
    options.limits.core_hours_per_day =
        std::max(0.2, core_s / 3600 / users * dice.log_uniform(0.5, 3));
  }
  scenario.faults = faults_of(seed, 3 * span_s, choice.wants);
  for (const Fault& fault : scenario.faults)
    last_s = std::max(last_s, fault.at_s + fault.for_s);
  scenario.quiet_s = last_s;
  return scenario;
}

double liveness_bound_s(const Scenario& scenario) {
  const Options& options = scenario.options;
  double bound_s = 5000;  // back-offs, stops and looks in progress
  double core_s = 0;
  for (const JobPlan& job : scenario.jobs) {
    // Assume that each job has one core and an extension, restarts as often as the slices allow,
    // and dies as often as possible.
    core_s += 2 * job.scan_core_s * static_cast<double>(job.scans);
    bound_s += 8 * job.scan_core_s * static_cast<double>(job.scans) +
               20 * (job.queue_s + job.begin_s + job.stop_s + options.look_after_launch_s);
  }
  if (options.limits.core_hours_per_day > 0)
    bound_s += (4 * core_s / 3600 / options.limits.core_hours_per_day + 2) * 86400;
  return bound_s;
}

}  // namespace sleight::jobs::simulated
