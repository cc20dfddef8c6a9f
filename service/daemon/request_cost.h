// The minimum cost of a request, computed before the run. A request that would run for years or
// exceed the memory is refused, and the refusal shows the cost.
//
//   `states`       are chains x temperatures, or x particles of an island. Each state is stored in
//                  memory, in the run store and in the archive.
//   `simulations`  are states x iterations per scan x scans, if [stop] limits the scans. Annealing
//                  and other work besides scans isn't counted. The cost isn't known for stop rules
//                  that depend on results (solutions, odds); limits on core-hours and bytes bound
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

/// Returns a refusal with the cost, or none if the cost is within the limits.
std::optional<rpc::Refusal> beyond_limits(const RequestCost& cost, const RequestLimits& limits);

}  // namespace sleight::daemon
