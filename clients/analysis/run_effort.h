// How many simulations a run took, counted from what its archive says of it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "clients/analysis/tempering.h"
#include "common/archive/model.h"
#include "common/request/direction_request.h"

namespace sleight::analysis {

struct RunSizes {
  std::optional<request::Method> method{};
  std::uint64_t chains = 0;
  std::uint64_t draws = 0;  ///< of each chain
  std::span<const Round> rounds{};
};

/// Simulations of the whole run: the number of proposals and of draws from the prior. A scan is
/// iterations_per_scan proposals at each temperature but the prior's, where it is one draw; a start
/// is a draw everywhere. The draws of temperatures that are added between rounds are counted as
/// scans, which is a little too much; ascents that had not ended are left out. NaN: unknown.
double simulations_of(const archive::Source& source, const std::string& request_text,
                      const RunSizes& sizes);

}  // namespace sleight::analysis
