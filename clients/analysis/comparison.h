// Compares two archives: their requests, the numbers of their animations, and how the animations
// look. Thread safety: pure functions.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "clients/browse/agreement.h"
#include "clients/browse/index.h"
#include "common/scene/scene.h"

namespace sleight::analysis {

/// A line that differs between two requests.
struct OtherLine {
  std::string key{};    ///< "stop.scans"; in an array's second table "constraint.place[2].x_mm"
  std::string first{};  ///< value in the first request; empty: missing
  std::string second{};
};

/// Returns the keys that differ between two normalised requests, in the first request's order.
std::vector<OtherLine> other_lines(const std::string& first, const std::string& second);

/// Mean and spread of a number over an archive's animations. Animations without the number don't
/// count.
struct Spread {
  std::size_t count = 0;
  double mean = 0;
  double sd = 0;
  double least = 0;
  double most = 0;
};

struct ComparedNumber {
  std::string name{};
  std::array<Spread, 2> of{};
};

/// Compares each number that both archives have. Leaves out chain, draw and lineage, because they
/// only identify animations.
std::vector<ComparedNumber> compared_numbers(const browse::Index& first,
                                             const browse::Index& second);

/// Result of testing whether the animations of two sets look alike.
struct ComparedLooks {
  std::array<std::size_t, 2> tested{};
  browse::NeighbourTest test{};
};

/// REQUIRES: both sets have animations, and their scenes are comparable to `scene`.
ComparedLooks compared_looks(const std::array<std::vector<const browse::Entry*>, 2>& sets,
                             const scene::Scene& scene, std::size_t threads);

}  // namespace sleight::analysis
