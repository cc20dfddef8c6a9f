// The minimum cost of a request, computed before the run. If a request would run for years or
// exceed the memory, it is refused. The refusal shows the cost.
//
//   `states`       are chains x temperatures, or chains x particles of an island. Each state is
//                  stored in memory, in the run store and in the archive.
//   `simulations`  are states x iterations per scan x scans, if [stop] limits the scans. Only scans
//                  count; annealing, for example, doesn't. If a stop rule depends on results
//                  (solutions, odds), the cost is unknown; limits on core-hours and bytes bound
//                  such runs.
//
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/request/direction_request.h"
#include "common/rpc/service.h"

namespace sleight::daemon {

struct RequestLimits {
  std::uint64_t states = 0;       ///< 0: no limit
  std::uint64_t simulations = 0;  ///< 0: no limit
};

struct RequestCost {
  std::uint64_t states = 0;
  std::optional<std::uint64_t>
      simulations{};              ///< none: the rule depends on results; capped at 2^64 - 1
  std::string states_sum{};       ///< "65,536 chains x 64 temperatures = 4,194,304 states"
  std::string simulations_sum{};  ///< "... x 10 iterations x 1,000 scans = ... simulations"
};

RequestCost cost_of(const request::DirectionRequest& request);

/// If the cost exceeds the limits, returns a refusal that shows the cost.
std::optional<rpc::Refusal> beyond_limits(const RequestCost& cost, const RequestLimits& limits);

}  // namespace sleight::daemon
