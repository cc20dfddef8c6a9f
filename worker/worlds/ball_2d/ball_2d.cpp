#include "worker/worlds/ball_2d/ball_2d.h"

#include <cmath>

#include "common/random/distributions.h"

namespace sleight::worlds::ball_2d {

Ball2d::State Ball2d::draw_prior(random::Stream& stream) const {
  const random::Normal normal{.mean = 0, .sd = parameters_.world.normal_sd_rad};
  State normals{};
  for (std::uint32_t i = 0; i < parameters_.world.collisions; ++i)
    normals[i] = normal.draw(stream);
  return normals;
}

double Ball2d::log_prior(const State& normals) const {
  const random::Normal normal{.mean = 0, .sd = parameters_.world.normal_sd_rad};
  double sum = 0;
  for (std::uint32_t i = 0; i < parameters_.world.collisions; ++i) {
    sum += normal.log_density(normals[i]);
  }
  return sum;
}

Landing Ball2d::simulate(const State& normals) const {
  return simulate_landing(parameters_.world, normals);
}

double Ball2d::log_constraint(const Landing& landing) const {
  const double x_diameters = landing.x_m / parameters_.world.diameter_m;
  const double deviation = (x_diameters - parameters_.constraint.target_diameters) /
                           parameters_.constraint.sigma_diameters;
  return -0.5 * deviation * deviation;
}

bool Ball2d::satisfied(const Landing& landing) const {
  const double x_diameters = landing.x_m / parameters_.world.diameter_m;
  return std::abs(x_diameters - parameters_.constraint.target_diameters) <=
         parameters_.constraint.tolerance_diameters;
}

sampling::Proposal<Ball2d::State> Ball2d::propose(const State& normals,
                                                  std::span<const double> scales,
                                                  random::Stream& stream) const {
  const double scale = scales.empty() ? 1 : scales.front();
  const double half_width = parameters_.proposal.change_half_width_rad * scale;
  const random::Uniform offset{.low = -half_width, .high = half_width};
  State candidate = normals;
  for (std::uint32_t j = 0; j < parameters_.world.collisions; ++j) {
    if (stream.uniform() < parameters_.proposal.change_probability) {
      candidate[j] += offset.draw(stream);
    }
  }
  // The proposal density is the same in both directions: the reverse changes the same normals, and
  // its offsets have the same density.
  return {.candidate = candidate, .log_q_ratio = 0, .kind = 0};
}

base::Bytes Ball2d::encode(const State& normals) const {
  const base::BytesView bytes =
      base::bytes_of(std::span<const double>(normals.data(), parameters_.world.collisions));
  return {bytes.begin(), bytes.end()};
}

std::optional<Ball2d::State> Ball2d::decode(base::BytesView bytes) const {
  base::ByteReader reader(bytes);
  State normals{};
  for (std::uint32_t i = 0; i < parameters_.world.collisions; ++i) {
    const std::optional<double> angle = reader.get<double>();
    if (!angle || !std::isfinite(*angle)) return std::nullopt;
    normals[i] = *angle;
  }
  if (!reader.at_end()) return std::nullopt;
  return normals;
}

std::vector<double> Ball2d::outcome_values(const Landing& landing) const {
  return {landing.x_m, landing.time_s};
}

}  // namespace sleight::worlds::ball_2d
