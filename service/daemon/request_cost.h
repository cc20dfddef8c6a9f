// What a request asks for at least, before anything runs: so that one that would take years, or
// more memory than there is, is refused with its sum.
//
//   states       chains x temperatures, or x particles of an island: each is kept in memory, in the
//                run's store and in the archive
//   simulations  states x iterations of a scan x scans, where [stop] says how many; annealing and
//                what a method needs beside its scans come on top. Rules that are judged by results
//                (solutions, odds) say nothing beforehand: limits of core-hours and bytes hold
//                those
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
  std::uint64_t states = 0;       ///< 0: none
  std::uint64_t simulations = 0;  ///< likewise
};

struct RequestCost {
  std::uint64_t states = 0;
  std::optional<std::uint64_t> simulations{};  ///< none: the rule doesn't say; at most 2^64 - 1
  std::string states_sum{};       ///< "65,536 chains x 64 temperatures = 4,194,304 states"
  std::string simulations_sum{};  ///< "... x 10 iterations x 1,000 scans = ... simulations"
};

RequestCost cost_of(const request::DirectionRequest& request);

/// Why it is refused, with the sum; none: it is within the limits.
std::optional<rpc::Refusal> beyond_limits(const RequestCost& cost, const RequestLimits& limits);

}  // namespace sleight::daemon
