// Counts the simulations of an archive's run, and its solutions, lineages and proposals. Reads the
// scans in batches.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clients/analysis/diagnosis.h"
#include "clients/analysis/tempering.h"
#include "common/archive/model.h"
#include "common/json/value.h"
#include "common/plan/failure.h"
#include "common/request/direction_request.h"

namespace sleight::analysis {

/// Maximum lineages per chain that are distinguished. If a chain has more lineages, the count is a
/// lower bound.
inline constexpr std::uint64_t k_lineages_max = std::uint64_t{1} << 22;

struct RunCounts {
  std::uint64_t satisfied = 0;         ///< scans
  std::uint64_t satisfied_judged = 0;  ///< among the judged scans
  std::uint64_t solutions = 0;         ///< distinct (chain, lineage) of satisfied scans
  bool solutions_more = false;         ///< more exist, because k_lineages_max was reached
};

/// Throws base::Error(bad_archive) if a dataset has an unexpected shape.
RunCounts run_counts(const archive::Source& source, const Round& judged);

/// Counts proposals by kind over the judged scans of all chains. Throws base::Error(bad_archive) if
/// a dataset has an unexpected shape.
std::vector<KindReport> kind_counts(const archive::Source& source, const Round& judged);

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

/// Returns, for example, {"total": 3, "search_gave_up": 2, "work_limit": 1}. Leaves out kinds that
/// didn't occur.
json::Value failures_json(const plan::FailureCounts& failures);

}  // namespace sleight::analysis
