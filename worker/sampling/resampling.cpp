#include "worker/sampling/resampling.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "common/random/discrete_distributions.h"

namespace sleight::sampling {
namespace {

/// Puts points at offset, offset + 1, ... on a circle whose length is the number of particles.
/// Returns the particles whose arcs contain the points. `offset`: from 0 to 1.
std::vector<std::uint32_t> ancestors_by_points(std::span<const double> shares, double offset) {
  const std::size_t count = shares.size();
  std::vector<std::uint32_t> ancestors;
  ancestors.reserve(count);
  // If rounding ends the arcs too early, the last particle of positive weight gets the last point.
  std::size_t last = count - 1;
  while (last > 0 && shares[last] <= 0)
    --last;
  std::size_t particle = 0;
  double end = static_cast<double>(count) * shares[0];
  for (std::size_t point = 0; point < count; ++point) {
    const double at = offset + static_cast<double>(point);
    while (at >= end && particle < last)
      end += static_cast<double>(count) * shares[++particle];
    ancestors.push_back(static_cast<std::uint32_t>(particle));
  }
  return ancestors;
}

void turn(std::vector<std::uint32_t>& ancestors, std::uint64_t places) {
  std::rotate(ancestors.begin(), ancestors.begin() + static_cast<std::ptrdiff_t>(places),
              ancestors.end());
}

}  // namespace

std::vector<std::uint32_t> resampled(std::span<const double> shares, random::Stream& stream) {
  CHECK(!shares.empty());
  std::vector<std::uint32_t> ancestors = ancestors_by_points(shares, stream.uniform());
  turn(ancestors, random::UniformInteger{.count = ancestors.size()}.draw(stream));
  return ancestors;
}

std::vector<std::uint32_t> resampled_with_first(std::span<const double> shares,
                                                random::Stream& stream) {
  CHECK(!shares.empty());
  CHECK_GT(shares[0], 0.0);
  // The first arc is [0, length]. An offset below `fraction` puts one more point into the arc.
  const double length = static_cast<double>(shares.size()) * shares[0];
  const double whole = std::floor(length);
  const double fraction = length - whole;
  // Weigh an offset by its number of points in the arc, because any of them may be rotated to place
  // 0.
  const double with_more = fraction * (whole + 1) / length;
  const double offset = stream.uniform() < with_more ? fraction * stream.uniform()
                                                     : fraction + (1 - fraction) * stream.uniform();
  std::vector<std::uint32_t> ancestors = ancestors_by_points(shares, offset);
  // The first arc's points come first. If rounding left no point in this arc, add a point.
  const auto points = static_cast<std::uint64_t>(std::ranges::count(ancestors, 0U));
  if (points == 0) {
    ancestors[0] = 0;
    return ancestors;
  }
  turn(ancestors, random::UniformInteger{.count = points}.draw(stream));
  return ancestors;
}

double effective_size(std::span<const double> shares) {
  double squares = 0;
  for (const double share : shares)
    squares += share * share;
  return 1 / squares;
}

}  // namespace sleight::sampling
