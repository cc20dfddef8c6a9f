// Measures how many events and how much time both algorithms need in the thesis's two experiments
// (3.3).
//
// Each number of bodies runs with several seeds, and results are means, as in the thesis. CPU times
// are of the thread, and include the start but no recording. Thread safety: pure functions, except
// for the clock.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "tests/scenes/shared/scenes.h"
#include "tests/thesis/tables_3/thesis_table.h"

namespace sleight::thesis {

struct Experiment {
  std::function<physics::scenes::Setting(std::uint32_t bodies, std::uint64_t seed)> setting;
  std::vector<std::uint32_t> sizes;
  std::uint64_t seeds = 1;  ///< 1, 2, ... up to this
};

/// Polyhedra move in a box of 10.5 m for `duration_s`.
Experiment boxed_polyhedra(double duration_s);
/// Grains fall through the funnel until 5 s after the last start, for at most `duration_s_max`.
Experiment hourglass(double duration_s_max);

/// Measures one row by both algorithms. Throws base::Error if a simulation fails, or if the
/// algorithms' numbers of collisions differ.
Row measure(const Experiment& experiment, std::uint32_t n);

}  // namespace sleight::thesis
