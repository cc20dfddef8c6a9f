#include "worker/sampling/round_statistics.h"

#include <cmath>
#include <limits>
#include <utility>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/sampling/swap.h"
#include "worker/sampling/temperature_steps.h"

namespace sleight::sampling {
RoundStatistics::RoundStatistics(std::vector<double> ladder, std::uint64_t scans)
    : ladder_(std::move(ladder)), scans_wanted_(scans), rejected_(ladder_.size() - 1, 0.0) {
  for (Batch& batch : batches_)
    batch.steps.resize(ladder_.size() - 1);
}

void RoundStatistics::add(std::span<const LevelScan> levels) {
  CHECK_EQ(levels.size(), ladder_.size());
  CHECK_LT(scans_, scans_wanted_);
  // Divide the round into parts of equal length.
  const std::uint64_t part = scans_ * k_batches / scans_wanted_;
  Batch& batch = batches_[part];
  for (std::size_t i = 0; i + 1 < ladder_.size(); ++i) {
    const double l = levels[i].log_constraint;
    const double ratio = log_swap_ratio({.hotter = ladder_[i],
                                         .cooler = ladder_[i + 1],
                                         .log_constraint_hotter = l,
                                         .log_constraint_cooler = levels[i + 1].log_constraint});
    rejected_[i] += ratio >= 0 ? 0 : -math::expm1(ratio);
    batch.steps[i].add(stone_log_weight(ladder_, i, l));
  }
  const LevelScan& coolest = levels.back();
  // A start that breaks a hard constraint isn't a draw from the target, so it doesn't count.
  const bool counts = coolest.satisfied && coolest.log_constraint != k_log_zero;
  batch.inverse.add(counts ? -coolest.log_constraint : k_log_zero);
  ++scans_;
}

std::vector<double> RoundStatistics::rejections() const {
  std::vector<double> rates;
  for (const double sum : rejected_)
    rates.push_back(sum / static_cast<double>(scans_));
  return rates;
}

/// Computes the jackknife estimate of `value`.
template <class Value>
Estimate RoundStatistics::jackknife(const Value& value) const {
  const double all = value(k_batches);
  std::vector<double> without;
  for (std::size_t left_out = 0; left_out < k_batches; ++left_out) {
    if (batches_[left_out].inverse.count() > 0) without.push_back(value(left_out));
  }
  const auto count = static_cast<double>(without.size());
  if (count < 2 || !std::isfinite(all)) return {all, std::numeric_limits<double>::quiet_NaN()};
  double mean = 0;
  for (const double x : without)
    mean += x / count;
  double squares = 0;
  for (const double x : without)
    squares += (x - mean) * (x - mean);
  return {all, std::sqrt((count - 1) / count * squares)};
}

double RoundStatistics::log_z_without(std::size_t left_out) const {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < ladder_.size(); ++i) {
    LogSum step;
    for (std::size_t b = 0; b < k_batches; ++b) {
      if (b != left_out) step.add(batches_[b].steps[i]);
    }
    sum += step.log_mean();
  }
  return sum;
}

std::vector<double> RoundStatistics::log_z_steps() const {
  std::vector<double> steps;
  for (std::size_t i = 0; i + 1 < ladder_.size(); ++i) {
    LogSum step;
    for (const Batch& batch : batches_)
      step.add(batch.steps[i]);
    steps.push_back(step.log_mean());
  }
  return steps;
}

Estimate RoundStatistics::log_z() const {
  return jackknife([&](std::size_t left_out) { return log_z_without(left_out); });
}

Estimate RoundStatistics::log_satisfied() const {
  return jackknife([&](std::size_t left_out) {
    LogSum inverse;
    for (std::size_t b = 0; b < k_batches; ++b) {
      if (b != left_out) inverse.add(batches_[b].inverse);
    }
    return log_z_without(left_out) + inverse.log_mean();
  });
}

}  // namespace sleight::sampling
