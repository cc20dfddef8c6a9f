#include "worker/sampling/ladder.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace sleight::sampling {
namespace {

/// Minimum rejection rate. This minimum keeps levels distinct even if no swap is rejected.
constexpr double k_rejection_min = 1e-3;

/// A monotone cubic through points. The slopes are harmonic means (Fritsch and Carlson).
class MonotoneCurve {
 public:
  MonotoneCurve(std::span<const double> x, std::span<const double> y)
      : x_(x.begin(), x.end()), y_(y.begin(), y.end()), slopes_(x.size()) {
    const std::size_t last = x.size() - 1;
    const auto chord = [&](std::size_t i) { return (y_[i + 1] - y_[i]) / (x_[i + 1] - x_[i]); };
    slopes_.front() = chord(0);
    slopes_.back() = chord(last - 1);
    for (std::size_t i = 1; i < last; ++i) {
      const double before = chord(i - 1);
      const double after = chord(i);
      const double h = x_[i] - x_[i - 1];
      const double k = x_[i + 1] - x_[i];
      const double w = 2 * k + h;
      const double v = k + 2 * h;
      slopes_[i] = before * after > 0 ? (w + v) / (w / before + v / after) : 0;
    }
  }
  double slope(std::size_t i) const { return slopes_[i]; }
  double at(double x) const {
    const auto above = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
    const auto i = static_cast<std::size_t>(above - x_.begin()) - 1;
    const double width = x_[i + 1] - x_[i];
    const double t = (x - x_[i]) / width;
    const double back = 1 - t;
    return y_[i] * back * back * (1 + 2 * t) + slopes_[i] * width * t * back * back +
           y_[i + 1] * t * t * (1 + 2 * back) - slopes_[i + 1] * width * t * t * back;
  }
  /// Finds x by bisection. REQUIRES: y between the first and the last value.
  double inverse(double y) const {
    double low = x_.front();
    double high = x_.back();
    while (true) {
      const double middle = 0.5 * (low + high);
      if (middle <= low || middle >= high) return high;
      (at(middle) < y ? low : high) = middle;
    }
  }

 private:
  std::vector<double> x_;
  std::vector<double> y_;
  std::vector<double> slopes_;
};

std::vector<double> floored(std::span<const double> rejections) {
  std::vector<double> rates(rejections.begin(), rejections.end());
  for (double& rate : rates)
    rate = std::max(rate, k_rejection_min);
  return rates;
}

}  // namespace

std::vector<double> first_ladder(std::uint32_t levels, std::uint32_t power) {
  CHECK_GE(levels, k_levels_min);
  CHECK_GT(power, 0U);
  CHECK_LT(power, 64U);
  std::vector<double> ladder;
  for (std::uint32_t i = 0; i < levels; ++i) {
    const double x = i / (levels - 1.0);
    double beta = x;
    for (std::uint32_t factor = 1; factor < power; ++factor)
      beta *= x;
    ladder.push_back(beta);
  }
  return ladder;
}

std::vector<double> annealing(double target, std::uint64_t anneal_scans, std::uint64_t first_scan,
                              std::uint64_t scans) {
  std::vector<double> betas;
  for (std::uint64_t scan = first_scan; scan < first_scan + scans; ++scan)
    betas.push_back(target * (static_cast<double>(scan) / static_cast<double>(anneal_scans)));
  return betas;
}

std::uint32_t levels_for(double barrier) {
  const double wanted = std::ceil(2 * barrier) + 1;
  return static_cast<std::uint32_t>(std::clamp(wanted, double{k_levels_min}, double{k_levels_max}));
}

std::vector<double> cumulative_barrier(std::span<const double> rejections) {
  std::vector<double> barrier{0};
  for (const double rejection : rejections)
    barrier.push_back(barrier.back() + rejection);
  return barrier;
}

std::vector<double> local_barrier(std::span<const double> ladder,
                                  std::span<const double> rejections) {
  CHECK_EQ(rejections.size() + 1, ladder.size());
  const MonotoneCurve curve(ladder, cumulative_barrier(rejections));
  std::vector<double> slopes;
  for (std::size_t i = 0; i < ladder.size(); ++i)
    slopes.push_back(curve.slope(i));
  return slopes;
}

std::vector<double> respaced(std::span<const double> ladder, std::span<const double> rejections,
                             std::uint32_t levels) {
  CHECK_EQ(rejections.size() + 1, ladder.size());
  CHECK_GE(levels, k_levels_min);
  const std::vector<double> barrier = cumulative_barrier(floored(rejections));
  const MonotoneCurve curve(ladder, barrier);
  std::vector<double> even{ladder.front()};
  for (std::uint32_t i = 1; i + 1 < levels; ++i)
    even.push_back(curve.inverse(barrier.back() * i / (levels - 1.0)));
  even.push_back(ladder.back());
  return even;
}

std::vector<double> finer(std::span<const double> ladder, std::uint32_t steps_per_level) {
  CHECK_GE(steps_per_level, 1U);
  std::vector<double> fine{ladder.front()};
  for (std::size_t level = 1; level < ladder.size(); ++level) {
    const double width = ladder[level] - ladder[level - 1];
    for (std::uint32_t step = 1; step < steps_per_level; ++step)
      fine.push_back(ladder[level - 1] + width * step / steps_per_level);
    fine.push_back(ladder[level]);
  }
  return fine;
}

double predicted_round_trip_rate(std::span<const double> rejections) {
  double sum = 0;
  for (const double rejection : rejections)
    sum += rejection / (1 - rejection);
  return 1 / (2 + 2 * sum);
}

double interpolated(std::span<const double> ladder, std::span<const double> values, double beta) {
  CHECK_EQ(ladder.size(), values.size());
  const auto above = std::upper_bound(ladder.begin() + 1, ladder.end() - 1, beta);
  const auto i = static_cast<std::size_t>(above - ladder.begin()) - 1;
  const double t = (beta - ladder[i]) / (ladder[i + 1] - ladder[i]);
  return values[i] + t * (values[i + 1] - values[i]);
}

}  // namespace sleight::sampling
