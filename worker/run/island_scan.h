// The islands of a chain in a sequential run. Islands provide the chain's start. Each scan ends
// with a conditional step, which provides Z, and some independence steps
// (worker/sampling/particle_steps.h). The chain's state never decides which steps are made, so the
// target stays invariant.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/plan/unit.h"
#include "worker/run/search_start.h"
#include "worker/sampling/island.h"
#include "worker/sampling/particle_steps.h"

namespace sleight::run {

/// Free islands per scan.
inline constexpr std::uint32_t k_free_islands = 3;
/// Each scan uses one island number for its conditional step, and two for each independence step.
/// Islands for starts have far greater numbers.
inline constexpr std::uint64_t k_islands_of_scan = 1 + 2 * k_free_islands;
inline constexpr std::uint64_t k_first_start_island = std::uint64_t{1} << 48U;
/// Maximum number of islands for a start. If all these islands die, the chain starts without
/// islands.
inline constexpr std::uint32_t k_start_islands_max = 100;

template <StagedWorld W>
class IslandScan {
 public:
  using Sample = sampling::Sample<W>;
  using Told = typename sampling::Islands<W>::Told;

  /// REQUIRES: `world` and `guide` outlive this object.
  IslandScan(const W& world, const typename W::Guide& guide, std::uint32_t particles,
             const sampling::ChainStreams& streams, Told told)
      : islands_(world, guide, {.particles = particles}, streams, std::move(told)) {}

  /// Tries islands in turn, and returns the first draw that one provides. Empty if none does.
  std::optional<Sample> start(std::uint64_t scan) const {
    const std::uint64_t first = k_first_start_island + scan * k_start_islands_max;
    for (std::uint32_t nth = 0; nth < k_start_islands_max; ++nth) {
      sampling::Island<W> island = islands_.free(first + nth);
      if (island.drawn) return std::move(island.drawn);
    }
    return std::nullopt;
  }

  struct Visit {
    Sample sample;
    bool is_new = false;                  ///< The sample is a free island's draw.
    std::vector<double> method_values{};  ///< Estimates of all free islands (island_estimate.h).
  };

  /// Makes a scan's islands. Call after the scan's local moves.
  Visit visit(std::uint64_t scan, Sample before) const {
    const std::uint64_t number = scan * k_islands_of_scan;
    sampling::ParticleSample<W> current{.sample = std::move(before), .log_z = {}};
    if (current.sample.log_constraint == sampling::k_log_zero) {
      // Accept any island if the state has zero density.
      current.log_z = sampling::k_log_zero;
    } else {
      sampling::conditional_step(islands_, number, current);
    }
    Visit visit{.sample = {}, .is_new = false, .method_values = {}};
    for (std::uint32_t nth = 0; nth < k_free_islands; ++nth) {
      const auto estimate = sampling::independence_step(islands_, number + 1 + 2 * nth, current);
      visit.is_new = visit.is_new || estimate.accepted;
      estimate.append_to(visit.method_values);
    }
    visit.sample = std::move(current.sample);
    return visit;
  }

 private:
  sampling::Islands<W> islands_;
};

}  // namespace sleight::run
