// Computes from an archive how many simulations its run took.
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
  std::uint64_t draws = 0;  ///< per chain
  std::span<const Round> rounds{};
};

/// Returns the number of simulations in the whole run: proposals and draws from the prior. A scan
/// is one draw at the prior's temperature, and iterations_per_scan proposals at each other
/// temperature. A start is a draw at all temperatures. If temperatures are added between rounds,
/// their draws count as scans, so the result is slightly too large. Unfinished ascents are left
/// out. NaN: unknown.
double simulations_of(const archive::Source& source, const std::string& request_text,
                      const RunSizes& sizes);

}  // namespace sleight::analysis
