// The 2D ball and exact draws of p_w p_c^beta, for tests of kernels.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/math/elementary.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/worlds/ball_2d/ball_2d.h"

namespace sleight::statistical {

using Ball = worlds::ball_2d::Ball2d;
using BallSample = sampling::Sample<Ball>;

/// Returns a test's streams. If a test uses random numbers for several purposes, each purpose needs
/// its own chain number.
inline sampling::ChainStreams streams_of(std::uint64_t seed, std::uint32_t chain) {
  return {.seed = seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}};
}

/// Draws exactly from p_w p_c^beta. Rejection is possible because p_c is at most 1.
template <sampling::Target T>
sampling::Sample<T> exact_draw(const T& target, double beta, random::Stream& stream) {
  while (true) {
    sampling::Sample<T> sample = sampling::evaluate(target, target.draw_prior(stream));
    if (math::log(stream.uniform()) < beta * sample.log_constraint) return sample;
  }
}

/// The tested quantities are each normal, the landing place, and both densities.
inline constexpr std::size_t k_ball_functions = 8;
inline std::array<double, k_ball_functions> ball_functions(const BallSample& sample) {
  const auto& normals = sample.state;
  return {normals[0], normals[1],         normals[2],       normals[3],
          normals[4], sample.outcome.x_m, sample.log_prior, sample.log_constraint};
}
inline constexpr std::array<const char*, k_ball_functions> k_ball_function_names = {
    "normal 1", "normal 2", "normal 3", "normal 4", "normal 5", "landing", "log p_w", "log p_c"};

}  // namespace sleight::statistical
