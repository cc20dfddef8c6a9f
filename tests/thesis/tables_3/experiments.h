// The thesis's two experiments (3.3), measured: events and time of both algorithms.
//
// Each number of bodies is run with several seeds, and the means count, as in the thesis. CPU time
// of the thread, start included; nothing is recorded.
// Thread safety: pure functions, but for the clock.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "worker/physics/scenes/scenes.h"

namespace sleight::thesis {

/// Means over seeds of one algorithm at one number of bodies: three columns of a table.
struct Cost {
  double events = 0;
  double total_s = 0;
  double ms_per_event() const { return 1e3 * total_s / events; }
};

struct Row {
  std::uint32_t n = 0;
  Cost sync;
  Cost async;
  double collisions = 0;  ///< mean, of two bodies and of static geometry; equal for both algorithms
  double speed_up() const { return sync.total_s / async.total_s; }
};

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

/// A table of the thesis: `n,sync_events,sync_ms_per_event,sync_s,async_events,...` after lines of
/// `#` and a heading. Empty if there is no such file; throws base::Error if it reads otherwise.
std::vector<Row> read_thesis_table(const std::string& path);

}  // namespace sleight::thesis
