// How two archives differ: their requests, the numbers of their animations, and how these look.
//
// Pure functions.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "clients/browse/agreement.h"
#include "clients/browse/index.h"
#include "common/scene/scene.h"

namespace sleight::analysis {

/// A line of one request, or of both, that the other has otherwise.
struct OtherLine {
  std::string key{};  ///< "stop.scans"; in the second table of an array "constraint.place[2].x_mm"
  std::string first{};  ///< its value there; empty: it is not there
  std::string second{};
};

/// In what two normalised requests differ, by their keys, in the order of the first.
std::vector<OtherLine> other_lines(const std::string& first, const std::string& second);

/// Mean and spread of a number over the animations of an archive that have it.
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

/// Each number that both have, but for chains, draws and lineages, which only count.
std::vector<ComparedNumber> compared_numbers(const browse::Index& first,
                                             const browse::Index& second);

/// Whether animations of two sets look alike: of each set, those whose nearest neighbours were
/// counted, and what was counted.
struct ComparedLooks {
  std::array<std::size_t, 2> tested{};
  browse::NeighbourTest test{};
};

/// REQUIRES: animations in both, of scenes that are comparable to `scene`.
ComparedLooks compared_looks(const std::array<std::vector<const browse::Entry*>, 2>& sets,
                             const scene::Scene& scene, std::size_t threads);

}  // namespace sleight::analysis
