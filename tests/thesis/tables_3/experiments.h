// The thesis's two experiments (3.3), measured: events and time of both algorithms.
//
// Each number of bodies is run with several seeds, and the means count, as in the thesis. CPU time
// of the thread, start included; nothing is recorded.
// Thread safety: pure functions, but for the clock.
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

/// Polyhedra in a box of 10.5 m, whatever their number, for `duration_s`.
Experiment boxed_polyhedra(double duration_s);
/// Grains through the funnel, until 5 s after the last one has started or for `duration_s_max`.
Experiment hourglass(double duration_s_max);

/// One row, by both algorithms. Throws base::Error when a simulation fails, or when the two
/// algorithms' simulations differ in the number of collisions.
Row measure(const Experiment& experiment, std::uint32_t n);

}  // namespace sleight::thesis
