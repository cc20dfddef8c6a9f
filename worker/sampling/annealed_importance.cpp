#include "worker/sampling/annealed_importance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/temperature_steps.h"

namespace sleight::sampling {
WeightSummary summary_of(std::span<const double> log_weights) {
  LogSum first;
  LogSum second;
  for (const double w : log_weights) {
    first.add(w);
    second.add(2 * w);
  }
  const auto n = static_cast<double>(log_weights.size());
  WeightSummary summary{.log_mean = {first.log_mean(), std::numeric_limits<double>::quiet_NaN()},
                        .effective_size = 0};
  if (first.log_sum() == k_log_zero) return summary;
  // The relative variance of the mean is n / (n-1) (1/size - 1/n).
  summary.effective_size = math::exp(2 * first.log_sum() - second.log_sum());
  if (n > 1)
    summary.log_mean.error =
        std::sqrt(std::max(0.0, n / (n - 1) * (1 / summary.effective_size - 1 / n)));
  return summary;
}

AnnealedImportance::AnnealedImportance(const BurnIn& burn_in, std::uint32_t lanes,
                                       std::uint32_t steps_per_level)
    : burn_in_(burn_in), lanes_(lanes) {
  CHECK_GE(lanes, 1U);
  const std::vector<double>& ladder = burn_in.next_ladder;
  betas_ = finer(ladder, steps_per_level);
  scales_.resize(betas_.size());
  for (std::size_t step = 1; step < betas_.size(); ++step)
    scales_[step] = burn_in.next_scales[(step - 1) / steps_per_level + 1];
}

std::optional<plan::Unit> AnnealedImportance::next_unit(std::uint64_t horizon,
                                                        std::uint32_t scans_max) {
  // Choose the lane that is furthest behind.
  Lane* chosen = nullptr;
  for (Lane& lane : lanes_) {
    if (lane.handed_out || burn_in_.scans + lane.scan >= horizon) continue;
    if (chosen == nullptr || lane.scan < chosen->scan) chosen = &lane;
  }
  if (chosen == nullptr) return std::nullopt;
  chosen->handed_out = true;
  const std::uint64_t step = chosen->scan % per_ascent();
  // A unit ends at the ascent's end, or where the proposal scales change.
  std::uint64_t scans = 1;
  const std::uint64_t most = std::min<std::uint64_t>(
      {per_ascent() - step, horizon - burn_in_.scans - chosen->scan, scans_max});
  while (scans < most &&
         (step == 0 ? scales_[step + scans] == scales_[1] : scales_[step + scans] == scales_[step]))
    ++scans;
  const auto first = betas_.begin() + static_cast<std::ptrdiff_t>(step);
  const auto lane = static_cast<std::uint32_t>(chosen - lanes_.data());
  return plan::Unit{.replica = {burn_in_.chain, lane_id(lane)},
                    .seed = burn_in_.seed,
                    .first_scan = base::ScanIndex{burn_in_.scans + chosen->scan},
                    .scans = static_cast<std::uint32_t>(scans),
                    .starts = chosen->scan == 0,
                    .lineage = chosen->lineage,
                    .inverse_temperatures =
                        std::vector<double>(first, first + static_cast<std::ptrdiff_t>(scans)),
                    .proposal_scales = scales_[step == 0 && scans > 1 ? 1 : step]};
}

void AnnealedImportance::consume(base::ReplicaId replica, std::uint64_t first_scan,
                                 std::span<const plan::ScanRecord> records) {
  const std::uint32_t index = replica.value - burn_in_.first_free.value;
  CHECK_LT(index, lanes_.size());
  Lane& lane = lanes_[index];
  CHECK_EQ(first_scan, burn_in_.scans + lane.scan);
  lane.handed_out = false;
  for (const plan::ScanRecord& record : records) {
    const std::uint64_t step = lane.scan % per_ascent();
    CHECK_EQ(record.inverse_temperature, betas_[step]);
    if (step == 0) {
      lane.log_weight = 0;
    } else {
      lane.log_weight += ascent_log_weight({.schedule = betas_,
                                            .to = step,
                                            .l_before = lane.last_log_constraint,
                                            .l_after = record.log_constraint});
    }
    lane.last_log_constraint = record.log_constraint;
    lane.lineage = record.lineage;
    if (step + 1 == per_ascent()) {
      lane.log_weights.push_back(lane.log_weight);
      const bool counts = record.satisfied && record.log_constraint != k_log_zero;
      lane.log_satisfied.push_back(counts ? lane.log_weight - record.log_constraint : k_log_zero);
      solutions_.add(burn_in_.scans + lane.scan, record);
    }
    ++lane.scan;
  }
}

std::uint64_t AnnealedImportance::scans() const {
  return burn_in_.scans + std::ranges::min_element(lanes_, {}, &Lane::scan)->scan;
}

std::uint64_t AnnealedImportance::draws() const {
  const std::uint64_t common = scans() - burn_in_.scans;
  return common / per_ascent() * lanes_.size();
}

std::vector<ChainPart::Row> AnnealedImportance::rows() const {
  // Collect the draws' weights. Draws are ordered by (ascent, lane).
  std::vector<double> weights;
  std::vector<double> satisfied;
  const std::uint64_t ascents = draws() / lanes_.size();
  for (std::uint64_t ascent = 0; ascent < ascents; ++ascent) {
    for (const Lane& lane : lanes_) {
      weights.push_back(lane.log_weights[ascent]);
      satisfied.push_back(lane.log_satisfied[ascent]);
    }
  }
  const WeightSummary z = summary_of(weights);
  const WeightSummary p = summary_of(satisfied);
  return {
      {"ascent_inverse_temperature", "inverse temperatures of an ascent", "ascent_step", betas_},
      {"log_weight", "log weight of the draw", "draw", weights},
      {"ais_log_z", "log of the mean weight", "", {z.log_mean.value}},
      {"ais_log_z_error", "standard error of ais_log_z", "", {z.log_mean.error}},
      {"ais_effective_size",
       "effective sample size: number of equally weighted draws with the same accuracy",
       "",
       {z.effective_size}},
      {"ais_log_p_satisfied",
       "log of the probability that a prior draw satisfies the constraint",
       "",
       {p.log_mean.value}},
      {"ais_log_p_satisfied_error",
       "standard error of ais_log_p_satisfied",
       "",
       {p.log_mean.error}}};
}

}  // namespace sleight::sampling
