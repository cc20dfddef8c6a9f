#include "worker/worlds/dice/throw_map.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/distributions.h"

namespace sleight::worlds::dice {
namespace {

/// Maximum number of misses that the map uses. Further misses would tell little more about the
/// place.
constexpr std::size_t k_misses_max = 8;
/// Minimum throws per number. With fewer, covariances are noise.
constexpr std::size_t k_throws_per_number = 3;
/// Factor by which g is widened, because few throws don't show all of g.
constexpr double k_widened = 1.2;
constexpr double k_variance_min = 1e-4;
/// A standard deviation below this multiple of the component's mean counts as 0.
constexpr double k_sd_min = 1e-9;

/// One of a throw's numbers. `place` is an index in (position, velocity, spin).
auto& at(auto& one, std::size_t place) {
  const auto axis = static_cast<Eigen::Index>(place % 3);
  if (place < 3) return one.position_m[axis];
  return place < 6 ? one.velocity_mps[axis] : one.spin_radps[axis];
}

/// Jointly normal numbers: the scores of a throw, then its misses.
struct Normals {
  std::size_t count = 0;
  std::vector<double> mean;
  std::vector<double> covariance;  ///< row by row

  double& cov(std::size_t i, std::size_t j) { return covariance[i * count + j]; }
};

Normals normals_of(const std::vector<std::vector<double>>& rows) {
  const std::size_t count = rows.front().size();
  Normals n{.count = count,
            .mean = std::vector<double>(count, 0),
            .covariance = std::vector<double>(count * count, 0)};
  const double share = 1 / static_cast<double>(rows.size());
  for (const std::vector<double>& row : rows) {
    for (std::size_t i = 0; i < count; ++i)
      n.mean[i] += share * row[i];
  }
  for (const std::vector<double>& row : rows) {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j)
        n.cov(i, j) += share * (row[i] - n.mean[i]) * (row[j] - n.mean[j]);
    }
  }
  return n;
}

/// Conditions the numbers on an event: the k-th number plus noise is 0. `noise_sd` is the noise's
/// standard deviation.
void condition_on_zero(Normals& n, std::size_t k, double noise_sd) {
  const double variance = n.cov(k, k) + noise_sd * noise_sd;
  if (!(variance > 0)) return;
  std::vector<double> with_k(n.count);
  for (std::size_t i = 0; i < n.count; ++i)
    with_k[i] = n.cov(i, k);
  const double mean = n.mean[k];
  for (std::size_t i = 0; i < n.count; ++i) {
    n.mean[i] -= with_k[i] / variance * mean;
    for (std::size_t j = 0; j < n.count; ++j)
      n.cov(i, j) -= with_k[i] * with_k[j] / variance;
  }
}

}  // namespace

ThrowMap::ThrowMap(const DieStart& start, std::span<const LoneThrow> throws) : start_(start) {
  DieThrow means{.position_m = start.position_m,
                 .velocity_mps = start.velocity_mps,
                 .spin_radps = start.spin_radps};
  DieThrow sds{.position_m = start.position_sd_m,
               .velocity_mps = start.velocity_sd_mps,
               .spin_radps = start.spin_sd_radps};
  for (std::size_t place = 0; place < k_components_max; ++place) {
    // If a standard deviation is within rounding of the mean, the component's score is noise.
    if (at(sds, place) > k_sd_min * std::fabs(at(means, place)))
      components_.push_back({place, at(means, place), at(sds, place)});
  }
  learn(throws);
}

ThrowMap::Scores ThrowMap::scores_of(const DieThrow& one) const {
  Scores scores{};
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const Component& component = components_[i];
    scores[i] = (at(one, component.place) - component.mean) / component.sd;
  }
  return scores;
}

bool ThrowMap::is_plausible(const DieThrow& one) const {
  const double t = math::log(1e4);
  const auto n = static_cast<double>(components_.size());
  const Scores scores = scores_of(one);
  double squares = 0;
  for (std::size_t i = 0; i < components_.size(); ++i)
    squares += scores[i] * scores[i];
  return squares <= n + 2 * std::sqrt(n * t) + 2 * t;
}

void ThrowMap::learn(std::span<const LoneThrow> throws) {
  if (components_.empty() || throws.empty() || throws.front().misses.empty()) return;
  const std::size_t scores = components_.size();
  const std::size_t misses = std::min(k_misses_max, throws.front().misses.size());
  if (throws.size() < k_throws_per_number * (scores + misses)) return;

  // Estimate the joint distribution of scores and misses, then condition the scores on misses of 0.
  std::vector<std::vector<double>> rows;
  for (const LoneThrow& one : throws) {
    CHECK_GE(one.misses.size(), misses);
    const Scores of_throw = scores_of(one.thrown);
    std::vector<double>& row = rows.emplace_back(of_throw.begin(), of_throw.begin() + scores);
    for (std::size_t k = 0; k < misses; ++k)
      row.push_back(one.misses[k].by);
  }
  Normals normals = normals_of(rows);
  for (std::size_t k = 0; k < misses; ++k)
    condition_on_zero(normals, scores + k, throws.front().misses[k].sigma);

  // Compute the Cholesky root for draws from g.
  for (std::size_t i = 0; i < scores; ++i) {
    mean_[i] = normals.mean[i];
    for (std::size_t j = 0; j <= i; ++j) {
      double rest = k_widened * normals.cov(i, j);
      for (std::size_t k = 0; k < j; ++k)
        rest -= root_[i][k] * root_[j][k];
      root_[i][j] = i == j ? std::sqrt(std::max(rest, k_variance_min)) : rest / root_[j][j];
    }
    log_root_determinant_ += math::log(root_[i][i]);
  }
  is_prior_ = false;
}

DieThrow ThrowMap::draw(random::Stream& stream) const {
  DieThrow one = draw_throw(start_, stream);
  if (is_prior_ || stream.uniform() < k_prior_share) return one;
  Scores normals{};
  for (std::size_t i = 0; i < components_.size(); ++i) {
    normals[i] = random::Normal{.mean = 0, .sd = 1}.draw(stream);
    double score = mean_[i];
    for (std::size_t k = 0; k <= i; ++k)
      score += root_[i][k] * normals[k];
    const Component& component = components_[i];
    at(one, component.place) = component.mean + component.sd * score;
  }
  return one;
}

double ThrowMap::log_g_over_p(const Scores& scores) const {
  // p is standard normal in the scores, and g is standard normal in its own coordinates; other
  // terms cancel.
  double squares_in_p = 0;
  double squares_in_g = 0;
  Scores normals{};
  for (std::size_t i = 0; i < components_.size(); ++i) {
    double rest = scores[i] - mean_[i];
    for (std::size_t k = 0; k < i; ++k)
      rest -= root_[i][k] * normals[k];
    normals[i] = rest / root_[i][i];
    squares_in_g += normals[i] * normals[i];
    squares_in_p += scores[i] * scores[i];
  }
  return 0.5 * (squares_in_p - squares_in_g) - log_root_determinant_;
}

double ThrowMap::prior_over_q(const DieThrow& one) const {
  if (is_prior_) return 1;
  return 1 / (k_prior_share + (1 - k_prior_share) * math::exp(log_g_over_p(scores_of(one))));
}

}  // namespace sleight::worlds::dice
