// Computes the number of simulations in an archive's run.
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
/// makes one draw at the prior's temperature and iterations_per_scan proposals at every other
/// temperature. A start makes one draw at every temperature. If temperatures are added between
/// rounds, their draws count as scans, so the result is slightly too large. Unfinished ascents are
/// left out. NaN: unknown.
double simulations_of(const archive::Source& source, const std::string& request_text,
                      const RunSizes& sizes);

}  // namespace sleight::analysis
