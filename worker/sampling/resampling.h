// Systematic resampling of an island's particles: selects each new particle's ancestor.
//
// Particles are arcs of a circle. An arc is as long as its particle's weight. Equally spaced points
// with one random offset select the ancestors. Then the list of ancestors is rotated by a random
// number of places. So each new particle descends from particle m with probability W_m.
//
// In conditional sequential Monte Carlo, the retained path keeps place 0. So the first new particle
// must descend from the first old particle. The first arc's expected number of points is count W_0.
// The offset is drawn on the condition that this arc has a point. An offset's weight is its number
// of points in this arc. Then one of these points is rotated to place 0. Source: Chopin and Singh,
// On particle Gibbs sampling (Bernoulli 21, 2015), section 4.3. Thread safety: pure functions of
// the stream.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/random/stream.h"

namespace sleight::sampling {

/// Returns each new particle's ancestor. REQUIRES: shares are normalised; at least one share is
/// above 0.
std::vector<std::uint32_t> resampled(std::span<const double> shares, random::Stream& stream);

/// Like resampled(), conditioned on the first ancestor being 0. REQUIRES: shares[0] > 0.
std::vector<std::uint32_t> resampled_with_first(std::span<const double> shares,
                                                random::Stream& stream);

/// Returns (sum of weights)^2 / sum of squares for normalised weights.
double effective_size(std::span<const double> shares);

}  // namespace sleight::sampling
