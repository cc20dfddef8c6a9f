// Resampling of an island's particles: which particle each of the next ones descends from.
//
// Systematic, with the assignments turned by a random number of places: particle n of the next ones
// descends from particle m with probability W_m for each n. Particles lie on a circle, each with an
// arc as long as its weight; equally spaced points with one random offset choose.
//
// Conditional on the first of the next ones descending from the first: for conditional sequential
// Monte Carlo, whose retained path keeps place 0. With L = (count W_0) expected points in the first
// arc, the offset is drawn given that the arc has a point, by the number of points that it has;
// then one of these points is turned to place 0. Source: N. Chopin, S. Singh, On particle Gibbs
// sampling (Bernoulli 21, 2015), section 4.3.
//
// Thread safety: pure functions of the stream.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/random/stream.h"

namespace sleight::sampling {

/// For each of the next particles, as many as there are weights, the number of its ancestor.
/// `shares` are weights that sum to 1. REQUIRES: one at least is above 0.
std::vector<std::uint32_t> resampled(std::span<const double> shares, random::Stream& stream);

/// The same given that the first ancestor is 0. REQUIRES: shares[0] > 0.
std::vector<std::uint32_t> resampled_with_first(std::span<const double> shares,
                                                random::Stream& stream);

/// (sum of weights)^2 / sum of squares, of shares that sum to 1: how many equal weights are worth
/// as much.
double effective_size(std::span<const double> shares);

}  // namespace sleight::sampling
