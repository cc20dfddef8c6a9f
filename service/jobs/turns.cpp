#include "service/jobs/turns.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "common/base/check.h"

namespace sleight::jobs {

Need need_of(const Job& job, const Shares& shares, std::uint32_t had, std::uint32_t cores_max) {
  Need need;
  need.cores_min = job.wishes.processes();
  need.cores_wished = std::max(cores_max, need.cores_min);
  need.memory_bytes = job.wishes.memory_of_all();
  const double share = std::ceil(shares.each() - static_cast<double>(had));
  need.cores = std::clamp(share < 1 ? 1 : static_cast<std::uint32_t>(share), need.cores_min,
                          need.cores_wished);
  return need;
}

std::uint32_t cores_given(const Need& need, std::uint32_t free, std::uint64_t others_claim) {
  CHECK_LE(need.cores_min, free);
  const std::uint64_t left = free - std::min<std::uint64_t>(free, others_claim);
  const auto given = std::clamp<std::uint64_t>(left, need.cores, need.cores_wished);
  return std::min(free, static_cast<std::uint32_t>(given));
}

double restart_cost_s(const Job& job, const Options& options) {
  const double measured_s = job.start_cost_s + job.stop_cost_s;
  return measured_s > 0 ? measured_s : options.restart_cost_guess_s;
}

double slice_s(const Job& job, const Options& options) {
  const double worth_s =
      std::max(options.slice_s_min, options.slice_per_cost * restart_cost_s(job, options));
  if (job.counts.scans > job.scans_at_attempt) return worth_s;
  // A scan may be longer than a slice, and a stop discards the scan. So after each turn without a
  // commit, the slice doubles.
  const auto doublings = static_cast<int>(std::min(job.fruitless, k_doublings_max));
  return std::max(worth_s, std::ldexp(options.slice_uncommitted_s, doublings));
}

bool is_worth_widening(const RunningJob& job, std::uint32_t cores, const Options& options) {
  if (cores <= job.cores) return false;
  const double saved_s = job.core_seconds / static_cast<double>(job.cores) -
                         job.core_seconds / static_cast<double>(cores);
  return saved_s >= options.slice_per_cost * job.restart_cost_s;
}

bool comes_before(const NextJob& next, double next_standing, const RunningJob& running,
                  double running_standing, const Options& options) {
  if (next.user == running.user) {
    return next.is_turn || std::tuple(-std::int64_t{next.priority}, next.id) <
                               std::tuple(-std::int64_t{running.priority}, running.id);
  }
  if (next.is_overdue) return true;
  // After the stop, the running job has no future use to count.
  return next_standing < running_standing - options.horizon_s * static_cast<double>(running.cores);
}

}  // namespace sleight::jobs
